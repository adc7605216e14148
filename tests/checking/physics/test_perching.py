from __future__ import annotations

import numpy as np
import pytest

from tamp.checking.physics.perching import on_rollers, rolls_on
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Cylinder, Object, Pose, Sphere, Task

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
