import time
from dataclasses import replace

import pytest

import tamp
from tamp.checking import check
from tamp.execution.record import Deviation
from tamp.pipeline.amends import Resuming
from tamp.pipeline.planning import plan
from tamp.pipeline.setup import prepare
from tamp.task import At, Box, Object, Pose, Task

SIDE = Box((0.05, 0.05, 0.05))
LOWER = Object("lower", SIDE, Pose((0.05, 0.2, 0.025)), At(Pose((0.05, -0.1, 0.025))))
UPPER = Object("upper", SIDE, Pose((-0.1, 0.2, 0.025)), At(Pose((0.05, -0.1, 0.075))))
TASK = Task("tower", (LOWER, UPPER))


@pytest.fixture(scope="module")
def setup():
    return prepare(TASK)


@pytest.fixture(scope="module")
def made():
    return plan(TASK, seed=0, timeout=300.0)


@pytest.fixture(scope="module")
def whole(made):
    return tamp.execute(TASK, made)


def stopped(made, whole, beside):
    """The execution up to where the lower block is put down, so far beside its goal [m]."""
    done = next(i for i, action in enumerate(made.actions) if action.name == "place") + 1
    x, y, z = made.goals["lower"].xyz
    here = {**made.start, "lower": Pose((x + beside, y, z - 0.001))}
    end = made.actions[done - 1].steps[-1].trajectory.positions[-1]
    off = Deviation("lower", "misplaced", beside, 0.0)
    log = (*whole.log[: done - 1], replace(whole.log[done - 1], deviations=(off,)))
    q = tuple(float(angle) for angle in end)
    return replace(whole, status="deviated", log=log, deviation=off, final_poses=here, configuration=q)


def resumed(setup, made, execution, spared=()):
    rest, amended = Resuming(setup, None, "adaptive", 1, time.monotonic() + 300.0).resume(made, execution, spared)
    placed = [] if rest is None else [a.arguments[0] for a in rest.actions if a.name in ("place", "stack")]
    return rest, amended, placed


def test_what_later_errands_count_on_is_put_right_before_them(setup, made, whole):
    execution = stopped(made, whole, 0.03)
    rest, amended, placed = resumed(setup, made, execution)
    assert (amended, placed) == ({"lower"}, ["lower", "upper"])
    assert dict(rest.start) == dict(execution.final_poses)
    assert check(TASK, rest, start=rest.start, goals=made.goals).accepted
    assert rest.actions[-1] == made.actions[-1]


def test_what_does_not_matter_to_the_rest_stays(setup, made, whole):
    _, amended, placed = resumed(setup, made, stopped(made, whole, 0.011))
    assert (amended, placed) == (set(), ["upper"])


def test_what_shall_not_be_put_right_again_stays(setup, made, whole):
    rest, amended, _ = resumed(setup, made, stopped(made, whole, 0.03), {"lower"})
    assert (rest, amended) == (None, set())


def test_what_cannot_be_put_right_stays(setup, made, whole):
    """The lower block stands where no arm reaches it."""
    execution = stopped(made, whole, 0.03)
    far = {**execution.final_poses, "lower": Pose((0.55, -0.55, 0.025))}
    rest, amended, _ = resumed(setup, made, replace(execution, final_poses=far))
    assert (rest, amended) == (None, set())
