from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from tamp.checking import Problem, Verdict, check
from tamp.checking.actions.given_way import told_apart
from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.serialization.goal_order import Ordering
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.pipeline.strategies.subproblems.subproblem import Asker
from tamp.task import Action, At, Box, Fall, Object, Plan, Pose, Task, load_robot

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


@pytest.mark.parametrize(("kind", "again"), [("support", False), ("release", True), ("collision", False)])
def test_nothing_is_put_again_where_the_checker_says_that_it_does_not_stay_or_meets_what_does(monkeypatch, kind, again):
    on_blue = replace(RED, goal=At(Pose((0.05, 0.2, 0.12))))
    setup = prepare(Task("stacked", (on_blue, replace(BLUE, goal=None))))
    asker = Asker(Progress(Attempt.of(setup, setup.start, load_robot("panda").home, None)), 0, math.inf, "adaptive")
    found = asker.ask(asker.workspace, 8, {"red"})
    wrong = Problem(len(found.plan) - 1, "stack(red, blue)", 0.0, kind, ("red", "blue"), 0.0, "red tips over")
    monkeypatch.setattr(Attempt, "checked", lambda self, plan: Verdict(problems=(wrong,)))
    assert asker.refused(found.plan, "red")
    assert (asker.ask(asker.workspace, 8, {"red"}).plan is not None) == again


def gives_way(monkeypatch, by: float, wrong_from: int) -> None:
    """The checker has blue give way to the first errand by so much [m], and refuses what comes after some actions."""
    checked = Attempt.checked

    def judged(self: Attempt, plan: Plan) -> Verdict:
        verdict = checked(self, replace(plan, actions=tuple(told_apart(action)[0] for action in plan.actions)))
        told = any(isinstance(step, Fall) for step in plan.steps)
        known = verdict.state.copy()
        gave_way = len(plan.actions) >= 4 and not told
        to = known.poses["blue"] + by * np.outer([0, 1, 0, 0], [0, 0, 0, 1])  # along y
        known.stayed, known.came = ({"blue": to}, {"blue"}) if gave_way else ({}, set())
        wrong = Problem(wrong_from, "pick(blue, table)", 0.0, "collision", ("blue",), 0.0, "blue is met elsewhere")
        return replace(verdict, problems=(wrong,) * (len(plan.actions) > wrong_from), state=known)

    monkeypatch.setattr(Attempt, "checked", judged)


@pytest.mark.parametrize(("by", "wrong_from", "whole"), [(0.01, 4, False), (0.01, 100, False), (0.001, 100, True)])
def test_what_gives_way_is_planned_with_where_it_has_come_to(monkeypatch, begin, by, wrong_from, whole):
    """A piece ends before it handles what has given way since it was planned; where that is little it does not."""
    progress, blue = Progress(begin), begin.workspace.start["blue"].pose
    there = replace(blue, xyz=(blue.xyz[0], blue.xyz[1] + by, blue.xyz[2]))
    found = Asker(progress, 0, math.inf, "adaptive").ask(begin.workspace, 8, None)
    assert [action.args[0] for action in found.plan if action.name == "pick"] == ["red", "blue"]
    gives_way(monkeypatch, by, wrong_from)
    refused = progress.take(found.plan, 0)
    assert not progress.rejections and len(progress.pieces) == 1
    assert (len(progress.pieces[0].actions), refused is None) == ((8, True) if whole else (4, False))
    assert progress.start["red"].pose == begin.workspace.goals["red"].pose
    falls = [step for step in progress.pieces[0].steps if isinstance(step, Fall)]
    if whole:  # it is where it shall be by then
        assert not falls and progress.start["blue"].pose == begin.workspace.goals["blue"].pose
    else:
        assert falls == [Fall("blue", there)] and progress.start["blue"].pose == there


def test_what_is_refused_before_anything_gives_way_is_sent_back(monkeypatch, begin):
    progress = Progress(begin)
    found = Asker(progress, 0, math.inf, "adaptive").ask(begin.workspace, 8, None)
    gives_way(monkeypatch, 0.01, 1)
    assert progress.take(found.plan, 0) and len(progress.rejections) == 1 and not progress.pieces
