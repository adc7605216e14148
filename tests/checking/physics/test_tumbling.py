from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking import check
from tamp.checking.physics.tumbling import sliding, tumbled
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.execution.settling.settle import let_fall
from tamp.task import At, Box, Object, Plan, Pose, Task, load_robot

WIDE, HIGH = 0.03, 0.2
HOME = load_robot("panda").home


def leaning(tilt: float, friction: float = 0.5) -> Object:
    """A stick on its lower right edge, which is at x = 0."""
    pivot = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, tilt, 0.0))
    return Object("stick", Box((WIDE, 0.05, HIGH)), pivot @ Pose((-WIDE / 2, 0.0, HIGH / 2)), friction=friction)


def lying(side: int, slid: float = 0.0) -> Pose:
    """Where it lies, fallen to the right or to the left of that edge."""
    return Pose.from_rpy((slid + side * HIGH / 2, 0.0, WIDE / 2), (0.0, side * np.pi / 2, 0.0))


def nothing_done(stick: Object, said: Pose) -> tuple[Task, Plan]:
    task = Task("tumbled", (replace(stick, goal=At(said)),))
    return task, Plan("tumbled", "panda", 0, {"stick": said}, HOME, {"stick": said}, ())


@pytest.mark.parametrize("tilt", [0.2, 0.4, 0.8, 1.2])
def test_what_starts_beyond_its_balance_falls_to_that_side_and_lies_there(tilt):
    assert check(*nothing_done(leaning(tilt), lying(1))).accepted
    for said in (lying(-1), lying(1, 0.04), lying(1, -0.1)):
        assert "settles" in str(check(*nothing_done(leaning(tilt), said)))


@pytest.mark.parametrize("tilt", [0.05, 0.1])
@pytest.mark.parametrize("side", [1, -1])
def test_what_starts_within_its_balance_does_not_fall_over(tilt, side):
    assert "settles" in str(check(*nothing_done(leaning(tilt), lying(side))))
    assert check(*nothing_done(leaning(tilt), Pose((-WIDE / 2, 0.0, HIGH / 2)))).accepted


def test_nobody_knows_what_falls_beside_something():
    stick, wall = leaning(0.4), Object("wall", Box((0.02, 0.2, 0.1)), Pose((0.15, 0.0, 0.05)))
    scene = Scene.of(Task("beside", (stick, wall)))
    state = State({"stick": lying(-1).matrix, "wall": wall.pose.matrix}, np.array(HOME))
    assert tumbled(scene, state, "stick", stick.pose.matrix, 0.0, DEFAULT) is None


@given(
    size=st.tuples(st.floats(0.03, 0.08), st.floats(0.05, 0.1), st.floats(0.1, 0.2)),
    tilt=st.floats(0.1, 1.4),
    friction=st.sampled_from([0.1, 0.3, 0.5, 1.0]),
)
@settings(max_examples=15, deadline=None)
def test_what_falls_over_in_the_simulator_may(size, tilt, friction):
    pivot = Pose.from_rpy((0.0, 0.0, 1e-4), (0.0, tilt, 0.0))
    brick = Object("stick", Box(size), pivot @ Pose((-size[0] / 2, 0.0, size[2] / 2)), friction=friction)
    task = Task("falls", (brick,))
    ended = let_fall(task.objects, {"stick": brick.pose}, table=task.table)
    state = State({"stick": ended["stick"].matrix}, np.array(HOME))
    assert tumbled(Scene.of(task), state, "stick", brick.pose.matrix, 0.0, DEFAULT) in (0.0, None)


@given(friction=st.floats(0.0, 2.0), lean=st.floats(0.0, 1.5))
def test_edges_slide_less_where_friction_is_more_and_what_leans_less(friction, lean):
    assert 0.0 < sliding(friction, lean) <= 1.0
    assert sliding(friction + 0.1, lean) <= sliding(friction, lean) <= sliding(friction, lean + 0.1)
