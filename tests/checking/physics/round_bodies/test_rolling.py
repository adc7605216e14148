"""Where balls and cans that lie come to rest: on what touches them from all sides of their middle, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.physics.round_bodies.rolling import rolls_down
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Cylinder, Object, Pose, Sphere, Task
from tamp.task.model import Capsule
from tests.checking.physics.heaps import turned

HIGH = 0.3
"""Of what is round above the table [m]."""
SLAB = Box((0.3, 0.3, 0.02))


def goes(shape, turn, under, yaw=0.0) -> bool:
    """Whether something round, HIGH above the table, rolls down on bodies, by shape and pose seen from its middle."""
    lifted = Pose((0.0, 0.0, HIGH))
    objects = [Object(f"under{k}", on, lifted @ pose) for k, (on, pose) in enumerate(under)]
    objects.append(Object("it", shape, Pose.from_rpy((0.0, 0.0, HIGH), turn)))
    objects = turned(tuple(objects), yaw)
    state = State({o.name: o.pose.matrix for o in objects}, np.zeros(7))
    return rolls_down(Scene.of(Task("rolling", objects)), state, "it", shape, DEFAULT)


def touched(radius, lean, around, gap=0.0):
    """A slab that a ball touches with its middle, whose face leans towards it from a side, by angles [rad]."""
    tilt = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, -lean, 0.0))
    return SLAB, Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, around)) @ tilt @ Pose((0.0, 0.0, -radius - gap - 0.01))


def posts(radius, away, sides):
    """Narrow posts on whose inner edges or corners a ball lies."""
    top = -np.sqrt(radius**2 - away**2)
    for side in sides:
        yield Box((0.01, 0.01, 0.1)), Pose.from_rpy((0, 0, 0), (0, 0, side)) @ Pose((away + 0.005, 0.0, top - 0.05))


LEANS = st.floats(0.1, 1.2)


@given(radius=st.floats(0.015, 0.04), one=LEANS, other=LEANS, yaw=st.floats(-3.0, 3.0), gap=st.floats(0.0, 2e-3))
@settings(max_examples=10, deadline=None)
def test_a_ball_and_a_can_lie_in_a_level_groove(radius, one, other, yaw, gap):
    groove = [touched(radius, one, 0.0, gap), touched(radius, other, np.pi, gap)]
    assert not goes(Sphere(radius), (0.0, 0.0, 0.0), groove, yaw)
    assert not goes(Cylinder(radius, 0.1), (np.pi / 2, 0.0, 0.0), groove, yaw)
    assert not goes(Capsule(radius, 0.1), (np.pi / 2, 0.0, 0.0), groove, yaw)


@given(radius=st.floats(0.015, 0.04), lean=LEANS, slope=st.floats(0.01, 0.3), yaw=st.floats(-3.0, 3.0))
@settings(max_examples=10, deadline=None)
def test_a_ball_rolls_down_a_groove_that_slopes(radius, lean, slope, yaw):
    tilt = Pose.from_rpy((0.0, 0.0, 0.0), (slope, 0.0, 0.0))
    groove = [(slab, tilt @ at) for slab, at in (touched(radius, lean, 0.0), touched(radius, lean, np.pi))]
    assert goes(Sphere(radius), (0.0, 0.0, 0.0), groove, yaw)


@given(radius=st.floats(0.015, 0.04), lean=st.floats(0.01, 1.0), uphill=LEANS, around=st.floats(1.7, 4.5))
@settings(max_examples=10, deadline=None)
def test_what_touches_a_ball_from_up_the_slope_does_not_hold_it(radius, lean, uphill, around):
    """Seen from above the slope pushes towards -x, and so does what touches the ball on its way up."""
    beside = touched(radius, np.pi / 2, around - np.pi)
    assert goes(Sphere(radius), (0.0, 0.0, 0.0), [touched(radius, lean, 0.0), beside])
    assert goes(Cylinder(radius, 0.1), (np.pi / 2, 0.0, 0.0), [touched(radius, lean, 0.0), touched(radius, 1.3, 0.0)])


@pytest.mark.parametrize(
    ("sides", "stays"),
    [
        ((0.0, 2.1, 4.2), True),
        (np.arange(12) * np.pi / 6, True),
        ((0.0, np.pi), True),  # level edges, as wide as the posts
        ((0.0, 0.8, 1.6), False),
    ],
)
@pytest.mark.parametrize("away", [0.008, 0.018])
def test_a_ball_lies_on_three_points_round_its_middle(sides, stays, away):
    assert goes(Sphere(0.02), (0.0, 0.0, 0.0), posts(0.02, away, sides), 0.3) != stays


@pytest.mark.parametrize(("sides", "stays"), [((0.0, 2.1, 4.2), True), ((0.0, np.pi), False), ((0.0, 0.8, 1.6), False)])
@pytest.mark.parametrize("away", [0.012, 0.03])
def test_a_ball_lies_on_three_others_and_not_on_two(sides, stays, away):
    down = -np.sqrt(0.04**2 - away**2)
    under = [(Sphere(0.02), Pose((away * np.cos(side), away * np.sin(side), down))) for side in sides]
    assert goes(Sphere(0.02), (0.0, 0.0, 0.0), under, 0.3) != stays


def test_nothing_round_lies_on_a_dome_or_beside_an_edge():
    dome, edge = (Sphere(0.04), Pose((0.0, 0.0, -0.06))), (SLAB, Pose((0.1495, 0.0, -0.03)))
    level = (SLAB, Pose((0.0, 0.0, -0.03)))
    for shape, turn in ((Sphere(0.02), (0.0, 0.0, 0.0)), (Cylinder(0.02, 0.1), (np.pi / 2, 0.0, 0.0))):
        assert goes(shape, turn, [dome])
        assert goes(shape, turn, [edge])
        assert not goes(shape, turn, [level])


def test_what_is_before_the_end_of_a_can_does_not_hold_it_from_rolling():
    slope, end = touched(0.02, 0.1, 0.0), (Box((0.2, 0.02, 0.2)), Pose((0.0, 0.0605, 0.0)))
    assert goes(Cylinder(0.02, 0.1), (np.pi / 2, 0.0, 0.0), [slope, end])
