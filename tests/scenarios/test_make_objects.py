from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import tamp.scenarios.make_objects as maker
from tamp.scenarios.parts import Part, centred, loft
from tamp.task import Mesh
from tamp.task.mesh.parts import bounds, parts, watertight

ROOT = Path(maker.__file__).resolve().parent / "objects"
NAMES = sorted(maker.OBJECTS)


def signed_volume(part: Part) -> float:
    return float(np.linalg.det(part.vertices[np.array(part.triangles)]).sum() / 6)


def test_enough_objects():
    assert {"bottle", "mug", "bowl", "plate", "can", "book", "tray", "open_box"} <= set(NAMES)
    assert sorted(p.name for p in ROOT.iterdir() if p.is_dir()) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_committed_file_is_what_the_script_makes(name):
    assert (ROOT / name / "collision.obj").read_text(encoding="utf-8") == maker.text(name)


@pytest.mark.parametrize("name", NAMES)
def test_every_part_is_closed_and_convex(name):
    from scipy.spatial import ConvexHull

    for part in maker.OBJECTS[name]():
        edges = [(t[i], t[(i + 1) % 3]) for t in part.triangles for i in range(3)]
        assert len(set(edges)) == len(edges), "two triangles run along an edge in the same direction"
        assert {(b, a) for a, b in edges} == set(edges), "an edge has no triangle on its other side"
        volume = signed_volume(part)
        assert volume > 0
        assert ConvexHull(part.vertices).volume == pytest.approx(volume, rel=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_the_framework_reads_the_file_as_the_same_parts(name):
    shape = Mesh(ROOT / name / "collision.obj")
    assert watertight(shape)
    assert len(parts(shape)) == len(maker.OBJECTS[name]())


@pytest.mark.parametrize("name", NAMES)
def test_origin_and_size(name):
    lower, upper = bounds(Mesh(ROOT / name / "collision.obj"))
    np.testing.assert_allclose(lower, -upper, atol=1.1e-6)
    assert (upper - lower).min() > 0.02 and (upper - lower).max() <= 0.30


@pytest.mark.parametrize("name", ["mug", "cup", "bowl", "plate", "open_box", "tray"])
def test_hollow_things_are_hollow(name):
    made = centred(maker.OBJECTS[name]())
    whole = np.vstack([part.vertices for part in made])
    extents = np.ptp(whole, axis=0)
    assert sum(map(signed_volume, made)) < 0.45 * float(np.prod(extents))


def test_a_loft_turns_its_faces_outward_whichever_end_comes_first():
    low, high = (np.array([(0.0, 0.0, z), (1.0, 0.0, z), (0.0, 1.0, z)]) for z in (0.0, 1.0))
    assert signed_volume(loft(low, high)) == pytest.approx(0.5)
    assert signed_volume(loft(high, low)) == pytest.approx(0.5)
