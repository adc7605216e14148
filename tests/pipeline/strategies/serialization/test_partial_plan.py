from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from tamp.checking import check
from tamp.execution.log import Deviation
from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.serialization.goal_order import Ordering
from tamp.pipeline.strategies.serialization.partial_plan import Attempt, Progress
from tamp.pipeline.strategies.serialization.subproblem import Asker
from tamp.task import Action, At, Box, Fall, Object, Plan, Pose, Task, load_robot
from tamp.task.files.load import load_task

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


@pytest.fixture(scope="module")
def whole(begin):
    """What a search has found for two blocks, piece by piece, and the plan that joins the pieces."""
    ordering = Ordering(begin, 0, time.monotonic() + 600.0, "adaptive")
    ordering.run()
    progress, workspace = ordering.progress, begin.workspace
    start = {name: place.pose for name, place in workspace.start.items()}
    goals = {name: place.pose for name, place in workspace.goals.items()}
    return progress, Plan("two", "panda", 0, start, begin.configuration.q, goals, tuple(progress.actions))


def sentences(verdict):
    return [problem.sentence for problem in verdict.problems]


@pytest.mark.parametrize("goals", [{}, {"red": FAR}, {"red": FAR, "blue": NEAR}])
def test_the_word_on_joined_pieces_is_that_on_the_whole_plan(whole, goals):
    progress, plan = whole
    plan = replace(plan, goals={**plan.goals, **goals})
    assert len(progress.pieces) == 2
    verdict = check(progress.now.setup.task, plan, start=plan.start, goals=plan.goals)
    assert verdict.executable
    assert verdict.accepted == (not goals)
    assert sentences(progress.checked(plan)) == sentences(verdict)


def test_nothing_is_said_of_a_plan_that_does_not_join_the_pieces(whole):
    progress, plan = whole
    first, second = progress.pieces
    assert progress.checked(replace(plan, actions=plan.actions[:-1])) is None
    assert progress.checked(replace(plan, start={**plan.start, "red": FAR})) is None
    assert progress.checked(replace(plan, home=(plan.home[0] + 0.001, *plan.home[1:]))) is None
    elsewhere = replace(second, start={**second.start, "red": FAR})
    assert replace(progress, pieces=[first, elsewhere]).checked(plan) is None


SCENARIOS = Path(__file__).parents[4] / "scenarios"


@pytest.fixture(scope="module")
def fallen():
    """A state, and a plan from there in which a book is laid down."""
    setup = prepare(load_task(SCENARIOS / "lay_book.yaml"))
    state = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    asker = Asker(Progress(state), 0, time.monotonic() + 600.0, "adaptive")
    plan = asker.ask(state.workspace, 30, None).plan
    assert plan
    return state, plan


def rehearsing(monkeypatch, status):
    """Let rehearsals end with a status; the list of what is rehearsed."""
    rehearsed = []

    def execute(task, plan, **how):
        rehearsed.append(plan)
        return SimpleNamespace(status=status, deviation=Deviation("book", "misplaced", 0.07, 0.99))

    monkeypatch.setattr("tamp.pipeline.strategies.serialization.partial_plan.execute", execute)
    return rehearsed


@pytest.mark.parametrize("status", ["deviated", "done", "timeout"])
def test_a_piece_in_which_something_falls_is_taken_as_its_rehearsal_ends(fallen, monkeypatch, status):
    (state, plan), rehearsed = fallen, rehearsing(monkeypatch, status)
    progress = Progress(state)
    refused = progress.take(plan, 0)
    assert len(rehearsed) == 1 and any(isinstance(step, Fall) for step in rehearsed[0].steps)
    if status == "deviated":
        assert refused == "rehearsed: book misplaced: off by 70.0 mm and 0.99 rad"
        assert not progress.actions and not progress.rejections
    else:
        assert refused is None and progress.actions


def test_what_goes_as_planned_in_the_simulator_is_taken(fallen):
    state, plan = fallen
    assert Progress(state).take(plan, 0) is None


def test_a_piece_in_which_nothing_falls_is_not_rehearsed(begin, monkeypatch):
    rehearsed = rehearsing(monkeypatch, "deviated")
    ordering = Ordering(begin, 0, time.monotonic() + 600.0, "adaptive")
    ordering.run()
    assert ordering.progress.actions and not ordering.left and not rehearsed
