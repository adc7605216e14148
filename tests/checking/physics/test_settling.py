"""What is written inside something is pushed out of it, and not along it; what falls, or rolls, goes where it must."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.physics.settling import unexplained
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Capsule, Cylinder, Object, Pose, Sphere, Task

THICK, SIZE = 0.04, 0.05


def astray(deep: float, out: float, along: float, yaw: float) -> float:
    """How far a block is from where settling takes it that is written `deep` in a wall, and said to stand beside it."""
    turn = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, yaw))
    wall = Object("wall", Box((0.3, THICK, 0.1)), turn @ Pose((0.0, 0.0, 0.05)), mass=5.0)
    beside = (THICK + SIZE) / 2
    block = Object("block", Box((SIZE, SIZE, SIZE)), turn @ Pose((0.0, beside - deep, SIZE / 2)))
    scene = Scene.of(Task("pushed", (wall, block)))
    said = turn @ Pose((along, beside + out, SIZE / 2))
    state = State({"wall": wall.pose.matrix, "block": said.matrix}, np.zeros(7))
    written = {"wall": wall.pose.matrix, "block": block.pose.matrix}
    return unexplained(scene, state, "block", written, DEFAULT)


@given(deep=st.floats(0.002, 0.015), out=st.floats(0.0, 0.003), yaw=st.floats(-3.0, 3.0))
@settings(max_examples=30, deadline=None)
def test_what_is_written_in_a_wall_comes_to_stand_beside_it(deep, out, yaw):
    assert astray(deep, out, 0.0, yaw) == 0.0


@given(deep=st.floats(0.006, 0.015), yaw=st.floats(-3.0, 3.0), to=st.sampled_from([-1.0, 1.0]))
@settings(max_examples=30, deadline=None)
def test_what_is_written_in_a_wall_is_not_pushed_along_it(deep, yaw, to):
    assert astray(deep, 0.0, to * (0.018 + deep), yaw) > 0.0


def ring(count: int, shift: float) -> float:
    """How far one of some cylinders on a circle, 5 mm apart, is from where it settles if all are said to stand further.

    Each is said to stand in part where the next one is written, so that what is said of the others would excuse it.
    """
    radius = 0.055 / (2 * np.sin(np.pi / count))

    def at(angle: float) -> Pose:
        return Pose((radius * np.cos(angle), radius * np.sin(angle), 0.04))

    angles = 2 * np.pi * np.arange(count) / count
    cans = [Object(f"can_{i}", Cylinder(0.025, 0.08), at(angle)) for i, angle in enumerate(angles)]
    written = {can.name: can.pose.matrix for can in cans}
    said = {can.name: at(angle + shift / radius).matrix for can, angle in zip(cans, angles, strict=True)}
    state = State(said, np.zeros(7))
    return unexplained(Scene.of(Task("ring", tuple(cans))), state, "can_0", written, DEFAULT)


@given(count=st.integers(5, 12), shift=st.floats(0.016, 0.05))
@settings(max_examples=30, deadline=None)
def test_no_plan_says_what_stands_in_an_object_s_place_at_first(count, shift):
    assert ring(count, shift) > 0.0


@pytest.mark.parametrize("mass", [0.002, 5.0])
def test_what_falls_pushes_nothing_away_that_it_is_said_to_roll_to(mass):
    ball = Object("ball", Sphere(0.03), Pose((0.0, 0.0, 0.07)), mass=mass)
    box = Object("box", Box((SIZE, SIZE, SIZE)), Pose((0.1, 0.0, SIZE / 2)))
    written = {"ball": ball.pose.matrix, "box": box.pose.matrix}
    said = {"ball": Pose((0.1, 0.0, 0.03)).matrix, "box": Pose((0.17, 0.0, SIZE / 2)).matrix}
    state = State(said, np.zeros(7))
    assert unexplained(Scene.of(Task("rolled", (ball, box))), state, "box", written, DEFAULT) > 0.05


LYING = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, np.pi / 2, np.pi / 2))


@pytest.mark.parametrize("shape", [Sphere(0.02), Cylinder(0.02, 0.06), Capsule(0.02, 0.06)])
@pytest.mark.parametrize("up", [0.03, 0.1])
@pytest.mark.parametrize(("rolls", "beside", "wrong"), [(0.03, False, True), (0.0, False, False), (0.03, True, False)])
def test_what_is_round_rolls_nowhere_from_where_it_falls_on_a_level_face(shape, up, rolls, beside, wrong):
    """Two simulators leave a ball that falls by 10 cm where it comes down, and a can within 2.3 mm.

    Where it comes down on the edge of something, nobody knows how far it goes.
    """
    thing = Object("it", shape, Pose((0.1, 0.0, 0.02 + up)) @ LYING)
    edge = Object("edge", Box((0.2, 0.2, 0.01)), Pose((0.215, 0.0, 0.005)), mass=5.0)
    objects = (thing, edge) if beside else (thing,)
    rolled = Pose.from_rpy((0.1 - rolls, 0.0, 0.02), (0.0, -rolls / 0.02, 0.0)) @ LYING
    scene = Scene.of(Task("rolls", objects))
    written = {each.name: each.pose.matrix for each in objects}
    state = State({**written, "it": rolled.matrix}, np.zeros(7))
    assert (unexplained(scene, state, "it", written, DEFAULT) > 0.01) == wrong
