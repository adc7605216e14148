from dataclasses import replace

import pytest

from tamp.pipeline.attempt import Attempt
from tamp.pipeline.progress import Progress
from tamp.pipeline.setup import prepare
from tamp.task import Action, At, Box, Object, Pose, Task, load_robot

SHAPE = Box((0.05, 0.05, 0.08))
RED = Object("red", SHAPE, Pose((0.05, 0.0, 0.04)), At(Pose((0.05, -0.2, 0.04))))
BLUE = Object("blue", SHAPE, Pose((0.05, 0.2, 0.04)), At(Pose((0.05, 0.25, 0.04))))
FAR, NEAR = Pose((-0.3, 0.0, 0.04)), Pose((0.05, 0.24, 0.04))


@pytest.fixture(scope="module")
def begin():
    setup = prepare(Task("two", (RED, BLUE)))
    return Attempt.of(setup, setup.start, load_robot("panda").home, None)


def after(state, **poses):
    start = state.workspace.start
    moved = {name: replace(start[name], pose=pose) for name, pose in poses.items()}
    return replace(state, workspace=replace(state.workspace, start={**start, **moved}))


@pytest.mark.parametrize(
    ("pieces", "kept"),
    [
        ([{"red": RED.goal.pose}], 1),
        ([{"blue": FAR}], 0),
        ([{"red": RED.goal.pose, "blue": FAR}], 0),  # 20 cm gained for 40 cm lost
        ([{"red": RED.goal.pose, "blue": FAR}, {"blue": NEAR}], 2),  # the buffer is emptied again
        ([{"red": RED.goal.pose}, {"blue": FAR}], 1),
    ],
)
def test_only_what_leaves_the_table_better_is_kept(begin, pieces, kept):
    progress = Progress(begin)
    states = [begin]
    for moved in pieces:
        progress.before.append((len(progress.actions), progress.now))
        progress.now = after(progress.now, **moved)
        progress.actions.append(Action("move", (), ()))
        states.append(progress.now)
    progress.cut_back()
    assert len(progress.actions) == kept
    assert progress.now is states[kept]
    assert len(progress.before) == kept
