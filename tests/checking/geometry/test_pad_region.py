"""What pads hold and what slips out of them; the simulator says the same of each of these bodies."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from tamp.checking.geometry.pad_region import squeezed_out
from tamp.checking.geometry.solids import Solid
from tamp.task import load_robot
from tamp.task.mesh.parts import Part, convex_hull

GRIPPER = load_robot("panda").gripper
FRICTION = 0.5


def slope(points: np.ndarray, depth: float = 0.0) -> float | None:
    """What the checker says of a convex body between the pads, which close along y [degrees]."""
    part: Part = convex_hull(points)
    found = squeezed_out(Solid.of("body", (part,)), np.eye(4), GRIPPER, GRIPPER.stroke, FRICTION, depth)
    return None if found is None else float(np.degrees(found))


def wedge(degrees: float, end: float = 0.03, drawn_in: float = 0.0) -> np.ndarray:
    """A bar along x whose two sides spread along z; `drawn_in` is how much shorter it is for each metre of width."""
    rise = np.tan(np.radians(degrees))
    width = {z: 0.008 + rise * z for z in (-0.0048 / rise, 0.013)}
    return np.array([(a * (end - drawn_in * w), b * w, z) for a in (-1, 1) for b in (-1, 1) for z, w in width.items()])


@pytest.mark.parametrize("end, drawn_in", [(0.03, 0.0), (0.006, 0.0), (0.006, 0.05)])
def test_pads_slip_off_a_wedge_that_is_steeper_than_the_cone_of_friction(end, drawn_in):
    assert slope(wedge(20.0, end, drawn_in)) is None
    assert slope(wedge(33.0, end, drawn_in)) == pytest.approx(33.0, abs=0.1)


@pytest.mark.parametrize("degrees", [15.0, 45.0, 60.0])
def test_a_ridge_across_the_pads_meets_their_faces(degrees):
    half = 0.01
    section = ((half, 0.0), (-half, 0.0), (0.0, half / np.tan(np.radians(degrees))))
    points = np.array([(x, y, s * z) for x in (-0.03, 0.03) for y, z in section for s in (1, -1)])
    assert slope(np.unique(points, axis=0)) is None


def test_a_ridge_that_rises_over_the_rim_is_as_steep_as_it_rises():
    tilt = np.radians(35.0)
    points = np.array([(x, s * (0.012 + np.tan(tilt) * x), 0.0) for x in (-0.012, 0.02) for s in (1, -1)])
    keel = np.array([(x, 0.0, z) for x in (-0.012, 0.02) for z in (-0.01, 0.01)])
    assert slope(np.concatenate([points, keel])) == pytest.approx(35.0, abs=0.5)


@given(st.floats(-17.0, 17.0), st.floats(-17.0, 17.0), st.floats(-0.02, 0.02), st.floats(-0.002, 0.006))
@settings(max_examples=60, deadline=None)
def test_a_thin_plate_is_held_at_its_edge_a_little_askew(about_x, about_z, x, z):
    """Where a pad's rim crosses the plate's bevelled edge it presses between two faces, one of which looks away."""
    corners = ((0.002, 0.0), (-0.002, -0.004), (0.002, -0.06), (-0.002, -0.06))
    plate = np.array([(a * 0.05, *corner) for a in (-1, 1) for corner in corners])
    turned = plate @ Rotation.from_euler("xz", (about_x, about_z), degrees=True).as_matrix().T
    assert slope(turned + np.array([x, 0.0, z])) is None


def test_it_is_asked_where_the_pads_are():
    up = wedge(33.0) + np.array([0.0, 0.0, 0.03])
    assert slope(up) is None  # the pads close below it
    assert slope(up, depth=0.03) == pytest.approx(33.0, abs=0.1)


def test_the_hull_is_that_of_the_points():
    points = wedge(33.0)
    assert ConvexHull(points).volume == pytest.approx(ConvexHull(convex_hull(points).vertices).volume)
