"""What stands stands, what tips tips, and what lies between the pads is what a ray would meet there."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.geometry.pad_region import between_pads
from tamp.checking.geometry.solids import Solid
from tamp.checking.physics.contacts import contacts
from tamp.task import Box, Cylinder, Pose, Shape, Sphere, load_robot
from tamp.task.mesh.parts import convex_hull, parts

TABLE = Solid.of("table", parts(Box((0.84, 1.2, 0.05))))
T_TABLE = Pose((0.0, 0.0, -0.025)).matrix


def balance(shape: Shape, pose: Pose, **others: tuple[Shape, Pose]) -> tuple[tuple[str, ...], float]:
    body = Solid.of("body", parts(shape))
    under = {name: (Solid.of(name, parts(other)), at.matrix) for name, (other, at) in others.items()}
    found = contacts(body, pose.matrix, {"table": (TABLE, T_TABLE), **under}, 0.003)
    T = pose.matrix
    friction = dict.fromkeys(("table", *others), 0.5)
    return found.bodies, found.balance(T[:3, :3] @ body.center_of_mass + T[:3, 3], friction, 0.001)


@given(yaw=st.floats(-3, 3), x=st.floats(-0.3, 0.3), y=st.floats(-0.4, 0.4))
@settings(max_examples=30, deadline=None)
def test_a_box_on_the_table_is_in_balance_by_half_its_width(yaw: float, x: float, y: float) -> None:
    bodies, inside = balance(Box((0.05, 0.07, 0.1)), Pose.from_rpy((x, y, 0.05), (0.0, 0.0, yaw)))
    assert bodies == ("table",)
    assert inside == pytest.approx(0.025, abs=3e-4)


@given(over=st.floats(-0.02, 0.02))
@settings(max_examples=30, deadline=None)
def test_a_box_over_the_edge_tips_when_its_centre_is_over_it(over: float) -> None:
    _, inside = balance(Box((0.06, 0.06, 0.06)), Pose((0.42 + over, 0.0, 0.03)))
    assert inside == pytest.approx(-over, abs=1e-3)


@given(offset=st.floats(-0.05, 0.05))
@settings(max_examples=30, deadline=None)
def test_a_plank_on_a_block(offset: float) -> None:
    bodies, inside = balance(
        Box((0.2, 0.05, 0.02)), Pose((offset, 0.0, 0.11)), block=(Box((0.06, 0.06, 0.1)), Pose((0.0, 0.0, 0.05)))
    )
    assert bodies == ("block",)
    assert inside == pytest.approx(min(0.025, 0.03 - abs(offset)), abs=1e-3)


def test_two_crossed_planks_meet_in_a_square() -> None:
    bodies, inside = balance(
        Box((0.2, 0.03, 0.02)), Pose((0.0, 0.0, 0.03)), other=(Box((0.03, 0.2, 0.02)), Pose((0.0, 0.0, 0.01)))
    )
    assert bodies == ("other",)
    assert inside == pytest.approx(0.015, abs=0.001)


@pytest.mark.parametrize("shape", [Sphere(0.03), Cylinder(0.03, 0.06)])
def test_round_things_rest_on_the_table(shape: Shape) -> None:
    assert balance(shape, Pose((0.0, 0.0, 0.03)))[1] >= 0.001


def test_a_cylinder_on_its_side_rests_and_on_its_edge_falls() -> None:
    assert balance(Cylinder(0.03, 0.1), Pose.from_rpy((0, 0, 0.03), (np.pi / 2, 0, 0)))[1] >= 0.001
    tilt = np.pi / 4
    height = 0.03 * np.sin(tilt) + 0.05 * np.cos(tilt)
    assert balance(Cylinder(0.03, 0.1), Pose.from_rpy((0, 0, height), (0, tilt, 0)))[1] < 0


def test_nothing_carries_what_hangs_in_the_air() -> None:
    bodies, inside = balance(Box((0.05, 0.05, 0.05)), Pose((0.0, 0.0, 0.03)))
    assert bodies == ()
    assert inside == -np.inf


def test_a_wall_beside_does_not_carry() -> None:
    bodies, _ = balance(
        Box((0.05, 0.05, 0.05)), Pose((0.0, 0.0, 0.2)), wall=(Box((0.05, 0.05, 0.4)), Pose((0.05, 0.0, 0.2)))
    )
    assert bodies == ()


GRIPPER = load_robot("panda").gripper


@given(x=st.floats(-0.005, 0.005), y=st.floats(-0.01, 0.01), z=st.floats(-0.03, 0.03))
@settings(max_examples=40, deadline=None)
def test_a_box_between_the_pads_is_as_wide_as_it_is(x: float, y: float, z: float) -> None:
    found = between_pads(Solid.of("box", parts(Box((0.05, 0.04, 0.08)))), Pose((x, y, z)).matrix, GRIPPER, 0.08)
    assert found == pytest.approx((y - 0.02, y + 0.02))


def test_a_cylinder_is_met_at_its_sides_and_a_wall_at_its_own() -> None:
    found = between_pads(Solid.of("can", parts(Cylinder(0.03, 0.1))), np.eye(4), GRIPPER, 0.08)
    assert found == pytest.approx((-0.03, 0.03), abs=1e-4)
    walls = [parts(Box((0.1, 0.004, 0.1)))[0].vertices + np.array([0.0, y, 0.0]) for y in (0.0, 0.1)]
    found = between_pads(Solid.of("tray", [convex_hull(wall) for wall in walls]), np.eye(4), GRIPPER, 0.08)
    assert found == pytest.approx((-0.002, 0.002))


@pytest.mark.parametrize("xyz", [(0.04, 0.0, 0.0), (0.0, 0.0, 0.06), (0.0, 0.07, 0.0)])
def test_nothing_is_between_the_pads(xyz: tuple[float, float, float]) -> None:
    assert between_pads(Solid.of("box", parts(Box((0.05, 0.04, 0.08)))), Pose(xyz).matrix, GRIPPER, 0.08) is None


def leaning(mu: float, tilt: float) -> float:
    """The balance of a plank that leans on a wall at `tilt` from the vertical, with friction `mu` at both ends."""
    length, thick = 0.2, 0.01
    x, z = length / 2 * np.sin(tilt), length / 2 * np.cos(tilt)
    lift, out = thick / 2 * np.sin(tilt), thick / 2 * np.cos(tilt)
    plank = Solid.of("plank", parts(Box((thick, 0.1, length))))
    wall = Solid.of("wall", parts(Box((0.1, 0.4, 0.4))))
    T = Pose.from_rpy((-x - out, 0.0, z + lift), (0.0, tilt, 0.0)).matrix
    found = contacts(plank, T, {"table": (TABLE, T_TABLE), "wall": (wall, Pose((0.05, 0.0, 0.2)).matrix)}, 0.001)
    assert set(found.patches) == {"table", "wall"}
    return found.balance(T[:3, 3], dict.fromkeys(found.patches, mu), 0.001)


@pytest.mark.parametrize("mu", [0.3, 0.5])
def test_a_plank_leans_as_steeply_as_friction_demands(mu: float) -> None:
    """A thin ladder between a floor and a wall of one coefficient stands up to twice the angle of friction."""
    limit = 2 * np.arctan(mu)
    assert leaning(mu, 0.85 * limit) >= 0.001
    assert leaning(mu, 1.15 * limit) < 0.0


def test_what_stands_on_a_slope_needs_friction() -> None:
    tilt = 0.4
    slope = Pose.from_rpy((0.0, 0.0, 0.1), (0.0, tilt, 0.0))
    body, ramp = Solid.of("body", parts(Box((0.05, 0.05, 0.03)))), Solid.of("ramp", parts(Box((0.3, 0.3, 0.02))))
    T = (slope @ Pose((0.0, 0.0, 0.025))).matrix
    found = contacts(body, T, {"ramp": (ramp, slope.matrix)}, 0.003)
    assert found.balance(T[:3, 3], {"ramp": 1.1 * np.tan(tilt)}, 0.001) >= 0.001
    assert found.balance(T[:3, 3], {"ramp": 0.9 * np.tan(tilt)}, 0.001) == -np.inf
