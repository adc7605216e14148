from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.task import Box, Cylinder, Mesh, Sphere
from tamp.world.geometry.object_geometry import load_geometry, stable_poses

OCRTOC = Path(__file__).parents[3].parent / "shared" / "ocrtoc" / "2021" / "models"

sizes = st.floats(0.01, 0.5)


@settings(max_examples=30, deadline=None)
@given(sizes, sizes, sizes)
def test_a_box_has_the_textbook_volume_centre_and_inertia(x, y, z):
    geometry = load_geometry(Box((x, y, z)))
    assert geometry.volume == pytest.approx(x * y * z)
    np.testing.assert_allclose(geometry.center_of_mass, 0, atol=1e-12)
    expected = np.diag([y * y + z * z, x * x + z * z, x * x + y * y]) / 12
    np.testing.assert_allclose(geometry.inertia, expected, atol=1e-12)
    np.testing.assert_allclose(geometry.upper - geometry.lower, (x, y, z))


@settings(max_examples=30, deadline=None)
@given(sizes, sizes, sizes)
def test_a_box_rests_on_its_six_faces(x, y, z):
    poses = stable_poses(load_geometry(Box((x, y, z))))
    assert sum(pose.probability for pose in poses) == pytest.approx(1)
    heights = sorted(pose.height for pose in poses)
    np.testing.assert_allclose(heights, sorted(2 * [x / 2, y / 2, z / 2]))


def test_the_chance_of_a_face_is_its_solid_angle():
    poses = stable_poses(load_geometry(Box((0.1, 0.1, 0.1))))
    np.testing.assert_allclose([pose.probability for pose in poses], 1 / 6)


def test_a_cylinder_stands_on_its_ends_and_lies_on_its_side():
    poses = stable_poses(load_geometry(Cylinder(0.03, 0.1)))
    axis = [abs(pose.R[2, 2]) for pose in poses]
    assert all(value > 0.999 or value < 0.001 for value in axis)
    assert sum(value > 0.999 for value in axis) == 2


def test_the_body_touches_the_plane_and_does_not_topple():
    for shape in (Sphere(0.04), Cylinder(0.02, 0.05), *_models()):
        geometry = load_geometry(shape)
        points = np.concatenate([part.vertices for part in geometry.parts])
        for pose in stable_poses(geometry):
            np.testing.assert_allclose(pose.R @ pose.R.T, np.eye(3), atol=1e-9)
            assert (points @ pose.R[2]).min() + pose.height == pytest.approx(0, abs=2e-4)
        assert sum(pose.probability for pose in stable_poses(geometry)) == pytest.approx(1)


def test_a_plate_lies_flat_one_way_or_the_other():
    for shape in _models():
        if shape.path.parent.name == "plate":
            first, second = stable_poses(load_geometry(shape))[:2]
            assert first.probability + second.probability > 0.99
            assert abs(first.R[2, 2]) > 0.99
            assert abs(second.R[2, 2]) > 0.99


def _models():
    if not OCRTOC.is_dir():
        pytest.skip("the OCRTOC models are not beside this checkout")
    return [Mesh(OCRTOC / name / "collision.obj") for name in ("plate", "bowl", "mug", "plate_holder", "power_drill")]
