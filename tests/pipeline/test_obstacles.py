import math

import pytest

from tamp.pipeline.attempt import Attempt
from tamp.pipeline.obstacles import barred, clearest_first, in_the_way
from tamp.pipeline.setup import prepare
from tamp.task import At, Box, Object, Pose, Task, load_robot
from tests.pipeline.samplers import no_grasp

CUBE = Box((0.05, 0.05, 0.05))
RED = Object("red", CUBE, Pose((0.1, 0.1, 0.025)), At(Pose((0.1, -0.2, 0.025))))
TOP = Object("top", CUBE, Pose((0.1, 0.1, 0.075)))
THERE = Object("there", CUBE, Pose((0.1, -0.2, 0.025)))
ON_THERE = Object("on_there", CUBE, Pose((0.1, -0.2, 0.075)))
FAR = Object("far", CUBE, Pose((-0.2, 0.4, 0.025)))


def obstacles(*objects, samplers=None):
    setup = prepare(Task("obstacles", objects))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, samplers)
    return in_the_way(attempt.workspace, "red", attempt.samplers, 0, math.inf)


def test_nothing_is_in_the_way_of_what_stands_and_shall_stand_alone():
    assert obstacles(RED, FAR) == set()


def test_what_stands_on_it_is_in_the_way():
    assert obstacles(RED, TOP, FAR) == {"top"}


def test_what_stands_at_the_goal_is_in_the_way_and_what_stands_on_that():
    assert obstacles(RED, THERE, ON_THERE, FAR) == {"there", "on_there"}


def test_who_leaves_the_hand_no_room_is_in_the_way():
    walls = [
        Object(f"wall-{n}", Box((0.02, 0.2, 0.25) if dx else (0.06, 0.02, 0.25)), Pose((0.1 + dx, 0.1 + dy, 0.125)))
        for n, (dx, dy) in enumerate(((0.045, 0.0), (-0.045, 0.0), (0.0, 0.045), (0.0, -0.045)))
    ]
    assert obstacles(RED, *walls, FAR) & {wall.name for wall in walls}
    assert "far" not in obstacles(RED, *walls, FAR)


def test_where_nobody_knows_a_grasp_all_others_may_be_in_the_way():
    assert obstacles(RED, FAR, samplers={"sample-grasp": no_grasp}) == {"far"}


def test_what_has_nothing_in_its_way_comes_first():
    setup = prepare(Task("obstacles", (RED, TOP, FAR)))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    assert clearest_first(attempt.workspace, ["red", "top", "far"], attempt.samplers, 0, math.inf) == [
        "top",
        "far",
        "red",
    ]


@pytest.mark.parametrize(
    ("others", "why"),
    [((FAR,), None), ((TOP, FAR), "top stands on red"), ((FAR, THERE), "red would overlap there")],
)
def test_what_is_covered_or_shall_stand_where_another_one_does_is_barred(others, why):
    setup = prepare(Task("barred", (RED, *others)))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    assert barred(attempt.workspace, "red", attempt.samplers, 0, math.inf) == why


def test_the_test_of_a_run_decides_what_is_barred():
    setup = prepare(Task("barred", (RED, THERE)))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, {"test-cfree-placements": lambda *_: True})
    assert barred(attempt.workspace, "red", attempt.samplers, 0, math.inf) is None
