from __future__ import annotations

import math
import time
from dataclasses import replace
from types import SimpleNamespace

import pytest

from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.known import Known
from tamp.pipeline.strategies.serialization import feasibility
from tamp.pipeline.strategies.serialization.feasibility import Prospects, barred, clearest_first, in_the_way
from tamp.pipeline.strategies.serialization.goal_order import Ordering
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.goal_graph import asking_for
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.pipeline.strategies.subproblems.subproblem import EFFORTS, Asker
from tamp.task import At, Box, Object, Pose, Task, load_robot
from tests.pipeline.samplers import no_grasp, no_slide

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
    assert clearest_first(attempt.workspace, ["red", "top", "far"], attempt.samplers, lambda name: 0, math.inf) == [
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


UPSIDE_DOWN = (1.0, 0.0, 0.0, 0.0)
BOARD = Object("board", Box((0.3, 0.3, 0.02)), Pose((-0.05, 0.3, 0.01)), At(Pose((-0.05, 0.3, 0.01), UPSIDE_DOWN)))
PROSPECTS_RED = Object("red", Box((0.05, 0.05, 0.08)), Pose((0.05, 0.0, 0.04)), At(Pose((0.05, -0.2, 0.04))))


@pytest.fixture
def attempt():
    """A board that no hand can turn over, and a block."""
    setup = prepare(Task("turn", (BOARD, PROSPECTS_RED)))
    return Attempt.of(setup, setup.start, load_robot("panda").home, {"plan-sliding": no_slide})


def prospects(attempt, seconds=600.0):
    return Prospects(Asker(Progress(attempt), 0, time.monotonic() + seconds, "adaptive"))


def test_what_does_not_get_to_its_goal_even_alone_is_remembered_with_a_reason(attempt):
    found = prospects(attempt)
    assert found.known_against("board") is None
    why = found.against("board")
    assert why.startswith("even alone: ")
    asked = len(found.asker.reports)
    assert found.against("board") == found.known_against("board") == why
    assert found.against("red") is None
    assert found.known_against("red") is None
    assert set(found.hopeless) == {"board"}
    assert len(found.asker.reports) == asked + 1
    assert set(found.plans) == {"red"}


def test_what_must_be_pushed_is_asked_about_without_regrasps_first_and_those_leave_time(attempt, monkeypatch):
    """Regrasps of what lies flat on the table may be sought in vain until time is up."""
    found, asked = prospects(attempt, 100.0), []

    def ask(self, _, iterations, *__, regrasped=(), **___):
        asked.append((iterations, bool(regrasped), self.deadline - time.monotonic()))
        return SimpleNamespace(plan=None, status="failed")

    monkeypatch.setattr(Asker, "ask", ask)
    monkeypatch.setattr(feasibility, "to_be_pushed", lambda *_: True)
    monkeypatch.setattr(feasibility, "reason", lambda solution: solution.status)
    assert found.against("red") is not None
    few = found.asker.tuning.alone_iterations
    assert [question[:2] for question in asked] == [(few, False), (2 * few, False), (2 * few, True)]
    assert [round(left / 100, 2) for _, _, left in asked] == [1.0, 1.0, feasibility.REGRASPING]


def test_a_question_tries_the_values_of_a_known_plan_first(attempt):
    found = prospects(attempt)
    assert found.against("red") is None
    known = found.plans["red"]
    found.asker.refusals["red"] += 1  # which has the question draw others
    asked = asking_for(found.asker.workspace, {"red"})
    guided, anew = (found.asker.ask(asked, 8, {"red"}, about="red", known=plan) for plan in (known, None))
    kinds = "pick", "place"
    values = [[action.args for action in answer.plan if action.name in kinds] for answer in (known, guided, anew)]
    assert values[0] == values[1] != values[2]


def test_how_an_object_reaches_its_goal_alone_guides_great_efforts_for_it(attempt, monkeypatch):
    asked = []

    def ask(self, *_, known=None, **__):
        asked.append(known)
        return SimpleNamespace(plan=None, status="failed", report=SimpleNamespace(skeletons=(), streams=()))

    ordering = Ordering(attempt, 0, time.monotonic() + 600.0, "adaptive")
    assert ordering._prospects.against("red") is None
    monkeypatch.setattr(Asker, "ask", ask)
    for effort in EFFORTS:
        ordering._try("red", effort)
    guide = ordering._prospects.plans["red"]
    assert asked == [guide if effort.guided else None for effort in EFFORTS]
    assert guide is not None
    # A plan that the checker sends back is no guide any more: it would come out again.
    monkeypatch.setattr(Asker, "ask", lambda self, *_, known=None, **__: asked.append(known) or guide)
    monkeypatch.setattr(Asker, "refused", lambda self, *_, **__: self.progress.rejections.append("wrong") or "wrong")
    for _ in range(2):
        ordering._try("red", EFFORTS[-1])
    assert asked[-2:] == [guide, None]


def test_what_time_cut_short_is_not_remembered(attempt):
    found = prospects(attempt, seconds=0.0)
    assert found.against("red") is not None
    assert found.hopeless == {}


@pytest.mark.parametrize(("hopeless", "first"), [({}, "board"), ({"board": "even alone: no grasp"}, "red")])
def test_what_is_known_to_be_hopeless_is_not_tried_before_all_else(attempt, monkeypatch, hopeless, first):
    class AskedError(Exception):
        pass

    def ask(self, workspace, *_, **__):
        raise AskedError(*(obj.name for obj in workspace.task.objects if obj.goal is not None))

    monkeypatch.setattr(Asker, "ask", ask)
    ordering = Ordering(attempt, 0, time.monotonic() + 600.0, "adaptive", Known(hopeless))
    with pytest.raises(AskedError) as asked:
        ordering.run()
    assert asked.value.args == (first,)


UPSIDE_DOWN = At(Pose((0.1, -0.2, 0.04), (1.0, 0.0, 0.0, 0.0)))


@pytest.mark.parametrize(("unturned", "regrasped"), [((), {"red"}), (("red",), set())])
def test_what_two_grasps_do_not_turn_over_is_not_asked_to_be(monkeypatch, unturned, regrasped):
    asked = []

    def ask(self, *_, regrasped=(), **__):
        asked.append({*regrasped})
        raise KeyboardInterrupt

    setup = prepare(Task("over", (replace(PROSPECTS_RED, goal=UPSIDE_DOWN),)))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    monkeypatch.setattr(Asker, "ask", ask)
    ordering = Ordering(attempt, 0, time.monotonic() + 600.0, "adaptive", Known(unturned=unturned))
    ordering._turned.add("red")  # by one grasp, and by itself, it was tried in vain
    with pytest.raises(KeyboardInterrupt):
        ordering.run()
    assert asked == [regrasped]
    assert ordering.unturned.keys() == {*unturned}


@pytest.mark.parametrize(("status", "times"), [("failed", 1), ("timeout", 2)])
def test_that_two_grasps_do_not_turn_something_over_is_asked_once(monkeypatch, status, times):
    setup = prepare(Task("over", (replace(PROSPECTS_RED, goal=UPSIDE_DOWN),)))
    found = prospects(Attempt.of(setup, setup.start, load_robot("panda").home, None))
    asked = []

    def ask(self, *_, regrasped=(), **__):
        asked.append({*regrasped})
        return SimpleNamespace(plan=None, status=status, report=SimpleNamespace(skeletons=(), streams=()))

    monkeypatch.setattr(Asker, "ask", ask)
    for _ in range(2):
        assert found.against("red") is not None
        found.hopeless.clear()
    assert asked.count({"red"}) == times
    assert found.asker.stays_unturned("red") == (status == "failed")


@pytest.mark.parametrize(("unturned", "least"), [((), 12), (("red",), 8)])
def test_what_two_grasps_do_not_turn_over_is_not_tried_in_the_end_either(monkeypatch, unturned, least):
    asked = []

    def ask(self, workspace, iterations, *_, **__):
        asked.append(iterations)
        return SimpleNamespace(
            plan=None, status="failed", report=SimpleNamespace(skeletons=(), streams=(), total_s=0.0)
        )

    setup = prepare(Task("over", (replace(PROSPECTS_RED, goal=UPSIDE_DOWN),)))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    monkeypatch.setattr(Asker, "ask", ask)
    ordering = Ordering(attempt, 0, time.monotonic() + 60.0, "adaptive", Known({"red": "even alone"}, unturned))
    ordering.run()
    assert max(asked) == least


def test_beyond_hope_is_also_what_shall_rest_on_what_is_hopeless():
    top = Object("top", Box((0.04, 0.04, 0.04)), Pose((0.15, 0.05, 0.02)), At(Pose((0.05, -0.2, 0.1))))
    aside = Object("aside", Box((0.04, 0.04, 0.04)), Pose((0.15, 0.25, 0.02)), At(Pose((0.15, -0.3, 0.02))))
    setup = prepare(Task("tower", (top, PROSPECTS_RED, aside)))
    found = prospects(Attempt.of(setup, setup.start, load_robot("panda").home, None))
    names = {"top", "red", "aside"}
    assert found.beyond_hope(names) == set()
    found.hopeless["red"] = found.asker.workspace.start["red"], "even alone: no grasp"
    assert found.beyond_hope(names) == {"red", "top"}


def test_what_shall_stand_in_the_robots_base_is_hopeless_without_a_search():
    base = load_robot("panda").T_world_base.xyz
    goal = At(Pose((base[0] - 0.05, base[1], 0.025)))
    setup = prepare(Task("base", (Object("red", CUBE, Pose((0.1, 0.1, 0.025)), goal),)))
    found = prospects(Attempt.of(setup, setup.start, load_robot("panda").home, None))
    assert found.against("red") == "even alone: red would stand in the robot's base"
    assert found.asker.reports == []


def test_where_a_goal_is_impossible_all_goals_together_are_not_searched_for():
    base = load_robot("panda").T_world_base.xyz
    goal = At(Pose((base[0] - 0.05, base[1], 0.025)))
    setup = prepare(Task("base", (Object("red", CUBE, Pose((0.1, 0.1, 0.025)), goal),)))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    search = Ordering(attempt, 0, time.monotonic() + 600.0, "adaptive", Known())
    search.run(persistent=True)
    assert search.left == {"red": "even alone: red would stand in the robot's base"}
    assert search.report.status == "solved"  # of no search: there was none
