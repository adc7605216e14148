from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.actions.left_standing import check_rest
from tamp.checking.geometry.transforms import rotation
from tamp.checking.physics.righting import lain
from tamp.checking.physics.round_bodies.perching import LADEN, on_rollers, perched, rolls_on
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Cylinder, Mesh, Object, Pose, Sphere, Task
from tests.checking.physics.heaps import said, turned

R = 0.02
CAN, BALL, BLOCK, DRUM = Cylinder(R, 0.1), Sphere(R), Box((0.03, 0.1, 2 * R)), Cylinder(R, 2 * R)
ACROSS = (np.pi / 2, 0.0, 0.0)
ALONG = (0.0, np.pi / 2, 0.0)
UPRIGHT = (0.0, 0.0, 0.0)


def scene_of(*things) -> tuple[Scene, State]:
    """Bodies, by shape, place and turn, that stand on the table; the last of them is called red."""
    names = [*(f"under{k}" for k in range(len(things) - 1)), "red"]
    objects = [
        Object(name, shape, Pose.from_rpy(at, turn)) for name, (shape, at, turn) in zip(names, things, strict=True)
    ]
    state = State({o.name: o.pose.matrix for o in objects}, np.zeros(7))
    return Scene.of(Task("rolling", tuple(objects))), state


@pytest.mark.parametrize(
    ("under", "rolls"),
    [
        ([(CAN, (-0.05, 0.0, R), ACROSS), (CAN, (0.05, 0.0, R), ACROSS)], True),
        ([(CAN, (x, 0.0, R), ACROSS) for x in (-0.05, 0.0, 0.05)], True),
        ([(BALL, at, UPRIGHT) for at in ((-0.05, -0.02, R), (0.05, -0.02, R), (0.0, 0.03, R))], True),
        ([(CAN, (-0.05, 0.0, R), ACROSS), (CAN, (0.04, 0.0, R), ALONG)], False),
        ([(CAN, (-0.05, 0.0, R), ACROSS), (BLOCK, (0.05, 0.0, R), UPRIGHT)], False),
        ([(DRUM, (-0.05, 0.0, R), UPRIGHT), (DRUM, (0.05, 0.0, R), UPRIGHT)], False),
    ],
)
def test_what_all_rolls_the_same_way_carries_nothing(under, rolls):
    scene, state = scene_of(*under, (Box((0.18, 0.1, 0.02)), (0.0, 0.0, 2 * R + 0.01), UPRIGHT))
    assert bool(list(on_rollers(scene, state, "red", DEFAULT))) == rolls


@pytest.mark.parametrize(
    ("shape", "turn", "ahead", "rolls"),
    [
        (CAN, ACROSS, (1.0, 0.0, 0.0), True),
        (CAN, ACROSS, (0.8, 0.6, 0.0), True),
        (CAN, ACROSS, (0.0, 1.0, 0.0), False),  # along its axis it slides
        (BALL, UPRIGHT, (0.6, 0.8, 0.0), True),
        (DRUM, UPRIGHT, (1.0, 0.0, 0.0), False),
        (Box((0.015, 0.1, 2 * R)), UPRIGHT, (1.0, 0.0, 0.0), False),
    ],
)
def test_what_is_round_rolls_on_when_the_hand_that_pushed_it_stops(shape, turn, ahead, rolls):
    scene, state = scene_of((shape, (0.1, 0.0, R), turn))
    assert rolls_on(scene, state, "red", np.array(ahead), DEFAULT) == rolls


def test_a_wall_ahead_stops_what_rolls():
    wall = (Box((0.03, 0.1, 0.1)), (0.1 + R + 0.015, 0.0, 0.05), UPRIGHT)
    scene, state = scene_of(wall, (CAN, (0.1, 0.0, R), ACROSS))
    assert not rolls_on(scene, state, "red", np.array([1.0, 0.0, 0.0]), DEFAULT)
    assert rolls_on(scene, state, "red", np.array([-1.0, 0.0, 0.0]), DEFAULT)


@given(yaw=st.floats(-3.0, 3.0), slope=st.floats(0.015, 0.2), radius=st.floats(0.015, 0.03), lying=st.booleans())
@settings(max_examples=8, deadline=None)
def test_what_is_round_rolls_down_the_least_slope(yaw, slope, radius, lying):
    slab = Object("slab", Box((0.2, 0.12, 0.02)), Pose.from_rpy((0.0, 0.0, 0.05), (0.0, slope, 0.0)), mass=1.0)
    foot = Object("foot", Box((0.2, 0.12, 0.01)), Pose((0.0, 0.0, 0.005)), mass=1.0)
    at = np.array([0.0, 0.0, 0.05]) + (0.01 + radius) * np.array([np.sin(slope), 0.0, np.cos(slope)])
    shape = Cylinder(radius, 0.06) if lying else Sphere(radius)
    ball = Object("it", shape, Pose.from_rpy(tuple(at), (np.pi / 2 * lying, 0.0, 0.0)), mass=0.2)
    assert any("rolls down" in sentence for sentence in said(check_rest, turned((slab, foot, ball), yaw)))


@given(
    yaw=st.floats(-3.0, 3.0),
    radius=st.floats(0.015, 0.03),
    x=st.floats(-0.05, 0.05),
    share=st.one_of(st.floats(0.01, 0.045), st.floats(0.055, 5.0)),
)
@settings(max_examples=8, deadline=None)
def test_what_is_round_stays_on_what_is_level_and_not_much_lighter(yaw, radius, x, share):
    slab = Object("slab", Box((0.2, 0.12, 0.02)), Pose((0.0, 0.0, 0.01)), mass=0.2 * share)
    ball = Object("it", Sphere(radius), Pose((x, 0.0, 0.02 + radius)), mass=0.2)
    sentences = said(check_rest, turned((slab, ball), yaw))
    assert bool(sentences) == (share < 1.0 / LADEN), sentences


def chisel(folder, tilt):
    """A tapering tool that lies on one of its facets, turned by `tilt` about a level axis aslant, on the table."""
    angles = np.arange(12) * np.pi / 6 + np.pi / 12
    rings = [(-0.1, 0.015), (0.1, 0.004)]
    corners = [(x, r * np.cos(a), r * np.sin(a)) for x, r in rings for a in angles]
    trimesh.convex.convex_hull(np.array(corners)).export(folder / "chisel.obj")
    lying = np.arctan2(0.011 * np.cos(np.pi / 12), 0.2)
    turn = rotation(np.array([np.sqrt(0.5), np.sqrt(0.5), 0.0]), -tilt) @ rotation(np.array([0.0, 1.0, 0.0]), lying)
    T = np.eye(4)
    T[:3, :3] = turn
    T[2, 3] = -(np.array(corners) @ turn[2]).min()
    task = Task("tool", (Object("tool", Mesh(str(folder / "chisel.obj")), Pose.from_matrix(T)),))
    return Scene.of(task), State({"tool": T}, np.zeros(7))


@pytest.mark.parametrize(("tilt", "stays"), [(0.0, True), (0.05, True), (-0.05, True), (-0.12, True), (-0.3, False)])
def test_what_lies_down_by_less_than_things_slump_stays_where_it_does_not_roll_then(tmp_path, tilt, stays):
    scene, state = chisel(tmp_path, tilt)
    far = scene.displacement("tool", state.poses["tool"], lain(scene, state, "tool", DEFAULT))
    assert (far <= DEFAULT.slump) == stays
    assert (not list(perched(scene, state, "tool", DEFAULT, DEFAULT.slump))) == stays
    assert (not list(perched(scene, state, "tool", DEFAULT))) == (tilt == 0.0)
