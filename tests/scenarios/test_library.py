from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from tamp.errors import TaskError
from tamp.scenarios.library.kinds import CATEGORIES
from tamp.scenarios.library.make import KINDS, draw, write_library
from tamp.scenarios.library.model import FILE, FOLDER, SETS, read_library
from tamp.scenarios.parts import centred, obj_text, volume
from tamp.task.mesh.parts import bounds, parts, watertight
from tamp.task.model import ANY_TURN

LIBRARY = read_library()


def test_many_objects_of_all_twelve_categories_in_both_sets():
    assert len(LIBRARY) >= 40
    for name in SETS:
        assert {model.category for model in LIBRARY if model.set == name} == set(CATEGORIES)


def test_committed_library_is_what_the_script_writes(tmp_path):
    write_library(tmp_path)
    written = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert written == {path.name: path.read_bytes() for path in FOLDER.iterdir()}


def test_committed_files_are_small():
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) < 400_000


@pytest.mark.parametrize("model", LIBRARY, ids=lambda model: model.name)
def test_a_model_is_what_its_entry_says(model):
    lower, upper = bounds(model.shape)
    np.testing.assert_allclose(lower, -upper, atol=1.1e-6)
    size = upper - lower
    assert size.min() > 0.008 and size.max() < 0.25
    assert 0.01 < model.mass < 0.5
    assert watertight(model.shape)
    for area in (model.top, model.hollow):
        assert area is None or (np.array(area) <= size[:2] + 1e-6).all()


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_any_size_of_a_kind_is_a_sound_body(kind, seed):
    drawn = draw(kind, seed)
    assert all(low <= drawn.sizes[name] <= high for name, (low, high) in kind.sizes.items())
    for part in drawn.body.parts:
        edges = [(t[i], t[(i + 1) % 3]) for t in part.triangles for i in range(3)]
        assert {(b, a) for a, b in edges} == set(edges) and len(set(edges)) == len(edges)
        assert ConvexHull(part.vertices).volume == pytest.approx(volume([part]), rel=1e-6)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_a_kind_looks_the_same_in_every_turn_of_its_symmetry(kind):
    points = np.vstack([part.vertices for part in centred(draw(kind, 1).body.parts)])
    directions = np.random.default_rng(0).normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    reach = (points @ directions.T).max(axis=0)
    for axis, fold in enumerate((kind.symmetry.x, kind.symmetry.y, kind.symmetry.z)):
        # Round things have flat sides, by which they differ a little from turn to turn.
        turned = points @ Rotation.from_rotvec(np.eye(3)[axis] * 2 * np.pi / fold).as_matrix().T
        allowed = 0.002 if fold == ANY_TURN else 1e-4
        np.testing.assert_allclose((turned @ directions.T).max(axis=0), reach, atol=allowed)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_a_draw_repeats_and_another_seed_differs(kind):
    texts = [obj_text(kind.name, draw(kind, seed).body.parts) for seed in (5, 5, 6)]
    assert texts[0] == texts[1] != texts[2]


@pytest.mark.parametrize("name", ["cup", "mug", "bowl", "plate", "dish", "basket", "penholder", "saucepan"])
def test_hollow_things_are_hollow(name):
    pieces = centred(next(draw(kind, 0).body.parts for kind in KINDS if kind.name == name))
    extents = np.ptp(np.vstack([part.vertices for part in pieces]), axis=0)
    assert volume(pieces) < 0.45 * float(np.prod(extents))


def test_the_framework_reads_the_files_as_the_same_parts():
    for kind in KINDS:
        model = next(model for model in LIBRARY if model.kind == kind.name)
        assert len(parts(model.shape)) == len(draw(kind, 0).body.parts)


def test_an_unseen_library_has_the_kinds_in_other_sizes(tmp_path):
    write_library(tmp_path, seed=7)
    unseen = read_library(tmp_path)
    assert [model.name for model in unseen] == [model.name for model in LIBRARY]
    assert all((bounds(a.shape)[1] != bounds(b.shape)[1]).any() for a, b in zip(unseen, LIBRARY, strict=True))


GOOD = "{name: a, category: cup, set: trial, mesh: a.obj, mass: 0.1, friction: 0.5, symmetry: {z: 360}}"


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (GOOD.replace("cup", "spaceship"), r"objects.yaml:2: objects\[0\].category: 'spaceship' must be one of toy, "),
        (GOOD.replace("trial", "both"), "must be one of trial, contest"),
        (GOOD.replace("0.1,", "-1,"), "mass: -1 must be a number over 0"),
        (GOOD.replace("a.obj", "b.obj"), "there is no file b.obj"),
        (GOOD.replace("a.obj", "../a.obj"), "there is no file"),
        (GOOD.replace("360", "none"), "must be a mapping of x, y, z to whole numbers"),
        (GOOD.replace("mass: 0.1, ", ""), "mass is missing"),
        (GOOD.replace("mass:", "wait:"), "unknown field"),
        (GOOD.replace("symmetry", "top: [1], symmetry"), "two lengths over 0"),
        (f"{GOOD}\n  - {GOOD}", "'a' is taken"),
        ("just text", "must be a mapping"),
    ],
)
def test_a_bad_library_is_refused_in_one_sentence(tmp_path: Path, entry, said):
    (tmp_path / "a.obj").write_text((FOLDER / "cup_1.obj").read_text())
    (tmp_path / FILE).write_text(f"objects:\n  - {entry}\n")
    with pytest.raises(TaskError, match=said) as caught:
        read_library(tmp_path)
    assert "\n" not in str(caught.value)
