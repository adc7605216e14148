from __future__ import annotations

import math
import time
from dataclasses import replace

import pytest

from tamp.checking import Problem, Verdict, check
from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.serialization.goal_order import Ordering
from tamp.pipeline.strategies.serialization.partial_plan import Attempt, Progress
from tamp.pipeline.strategies.serialization.subproblem import Asker
from tamp.task import Action, At, Box, Object, Plan, Pose, Task, load_robot

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


@pytest.mark.parametrize("kind", ["support", "release"])
def test_nothing_is_put_again_where_the_checker_says_that_it_does_not_stay(monkeypatch, kind):
    on_blue = replace(RED, goal=At(Pose((0.05, 0.2, 0.12))))
    setup = prepare(Task("stacked", (on_blue, replace(BLUE, goal=None))))
    asker = Asker(Progress(Attempt.of(setup, setup.start, load_robot("panda").home, None)), 0, math.inf, "adaptive")
    found = asker.ask(asker.workspace, 8, {"red"})
    wrong = Problem(len(found.plan) - 1, "stack(red, blue)", 0.0, kind, ("red", "blue"), 0.0, "red tips over")
    monkeypatch.setattr(Attempt, "checked", lambda self, plan: Verdict(problems=(wrong,)))
    assert asker.refused(found.plan, "red")
    assert (asker.ask(asker.workspace, 8, {"red"}).plan is None) == (kind == "support")
