from __future__ import annotations

import math
import time
from dataclasses import replace

import pytest

import tamp
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.plan import Planning
from tamp.pipeline.prepare import prepare
from tamp.pipeline.solving.job import Job
from tamp.pipeline.strategies.serialization import goal_stability
from tamp.pipeline.strategies.serialization.feasibility import Prospects
from tamp.pipeline.strategies.serialization.goal_order import Ordering
from tamp.pipeline.strategies.serialization.goal_stability import GoalStability
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.subproblem import EFFORTS, Asker
from tamp.planning import Report, Solution
from tamp.streams.values import Placement
from tamp.task import At, Box, Cylinder, Object, On, Pose, Region, Release, Task, load_robot
from tests.pipeline.samplers import NO_HANDS, from_above, no_grasp, no_slide
from tests.streams.tables import CRATE

RED = Object("red", Box((0.05, 0.05, 0.08)), Pose((0.05, 0.0, 0.04)), At(Pose((0.05, -0.2, 0.04))))
TOP = Object("top", Box((0.04, 0.04, 0.04)), Pose((0.15, 0.05, 0.02)), At(Pose((0.05, -0.2, 0.1))))
CUBE = Object("cube", Box((0.04, 0.04, 0.04)), Pose((0.15, 0.25, 0.02)), At(Pose((0.15, -0.3, 0.02))))
CLOSE = Object("close", Box((0.04, 0.04, 0.04)), Pose((-0.1, 0.2, 0.02)), At(Pose((-0.1, 0.3, 0.02))))


def only_red(context, obj):
    yield from from_above(context, obj) if obj == "red" else no_grasp(context, obj)


@pytest.mark.parametrize(("beside", "tries"), [(0.0, 2), (0.35, 1)])
def test_a_short_try_in_vain_waits_for_a_change_nearby(monkeypatch, beside, tries):
    cube = replace(CUBE, pose=Pose((0.15 - beside, 0.02 + beside, 0.02)), goal=At(Pose((0.15 - beside, 0.4, 0.02))))
    setup = prepare(Task("vain", (cube, RED)))
    samplers = {**NO_HANDS, "sample-grasp": only_red}
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, samplers)
    asked = []

    def ask(asker, workspace, iterations, movable, *rest, ask=Asker.ask, **options):
        asked.append(movable)
        return ask(asker, workspace, iterations, movable, *rest, **options)

    monkeypatch.setattr(Asker, "ask", ask)
    search = Ordering(attempt, 0, time.monotonic() + 600.0, "adaptive")
    assert search._try_each(EFFORTS[0])  # red leaves
    assert not search._try_each(EFFORTS[0])
    assert asked.count({"cube"}) == tries


HOME = load_robot("panda").home
UPSIDE_DOWN = (1.0, 0.0, 0.0, 0.0)
BOARD = Object("board", Box((0.3, 0.3, 0.02)), Pose((-0.05, 0.3, 0.01)), At(Pose((-0.05, 0.3, 0.01), UPSIDE_DOWN)))


def search(task, seconds, samplers=None, seed=0):
    setup = prepare(task)
    deadline = time.monotonic() + seconds
    return Planning(setup, setup.start, HOME, seed=seed, deadline=deadline, settings=Settings(samplers=samplers or {}))


def attempt(task):
    setup = prepare(task)
    return Attempt.of(setup, setup.start, HOME, None)


def test_what_cannot_be_done_is_left_with_a_reason_and_the_rest_is_done():
    once = {"max_vain_plans": 1}
    result = tamp.solve(Task("turn", (BOARD, RED)), timeout=300.0, samplers={"plan-sliding": no_slide}, tuning=once)
    assert result.status == "failed"
    assert dict(result.goals_met) == {"board": False, "red": True}
    assert not result.plan_checked
    assert "board left: " in result.message
    assert "red left" not in result.message
    assert result.n_actions == 4


def test_where_nothing_can_be_done_it_says_why_for_each_object():
    planning = search(Task("none", (RED, TOP)), 300.0, NO_HANDS)
    assert planning.run() is None
    assert list(planning.left) == ["red", "top"]
    assert planning.left["red"].endswith("nobody grasps red")
    assert planning.left["top"] == "its goal rests on red, which is not at its own"


@pytest.mark.parametrize(("off", "counts"), [(0.02, True), (0.04, False)])
def test_what_cannot_be_brought_nearer_counts_as_there_within_what_a_solved_task_asks(off, counts):
    red = replace(RED, pose=Pose((0.05 + off, -0.2, 0.04)))
    job = Job(Task("near", (red,)), 0, 300.0, Settings(samplers=NO_HANDS))
    setup = prepare(job.task)
    assert job.plan(setup, setup.start, HOME) is counts
    if counts:
        assert job.plans[0].actions == ()
        assert job.plans[0].report["left"] == {}
        job.final_poses = dict(setup.start)
        assert job.astray(setup) == set()  # so it is not planned for again


def test_what_rests_on_something_that_counts_as_there_is_brought_to_its_goal():
    board = Object("board", BOARD.shape, Pose((0.07, -0.2, 0.01)), At(Pose((0.05, -0.2, 0.01))))
    red = replace(RED, goal=At(Pose((0.05, -0.2, 0.06))))
    plan = search(Task("rest", (board, red)), 300.0).run()
    assert plan.report["left"] == {}
    assert [action.arguments[0] for action in plan.actions if action.name == "stack"] == ["red"]


def test_objects_that_fill_their_region_are_brought_there_one_by_one_and_leave_each_other_room():
    narrow = Region("narrow", (0.05, -0.25), (0.12, 0.14))
    boxes = [
        Object(f"box_{k}", Box((0.04, 0.04, 0.08)), Pose((-0.1 + 0.08 * k, 0.2, 0.04)), On("narrow")) for k in range(5)
    ]
    setup = prepare(Task("narrow", tuple(boxes), regions=(narrow,)))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    search = Ordering(attempt, 0, time.monotonic() + 600.0, "adaptive")
    search.run()
    assert not search.left
    assert len(search.progress.pieces) == len(boxes)
    assert [action.name for action in search.progress.actions].count("pick") == len(boxes)


def test_what_can_be_done_leaves_nothing():
    plan = search(Task("stack", (TOP, RED)), 300.0).run()
    assert plan.report["left"] == {}
    placed = [action.arguments for action in plan.actions if action.name in ("place", "stack")]
    # What the other one rests on comes first, whatever their order in the task.
    assert placed == [("red", "table"), ("top", "red")]


def test_what_would_stand_on_something_that_is_left_is_brought_near():
    on_board = Object("red", RED.shape, Pose((0.1, -0.1, 0.04)), At(Pose((-0.05, 0.3, 0.06))))
    board = Object("board", Box((0.2, 0.2, 0.02)), Pose((-0.15, -0.25, 0.01)), At(Pose((-0.05, 0.3, 0.01))))
    slides = dict.fromkeys(("plan-sliding", "plan-sliding-to"), no_slide)
    planning = search(Task("brought", (board, on_board)), 300.0, slides)
    plan = planning.run()
    assert set(planning.left) == {"board", "red"}
    assert planning.left["red"] == "its goal rests on board, which is not at its own"
    assert [action.arguments[0] for action in plan.actions if action.name == "place"] == ["red"]
    release = next(step for step in plan.steps if isinstance(step, Release))
    assert math.dist(release.pose.xyz, plan.goals["red"].xyz) < 0.03


def test_others_step_aside_where_the_goal_is_taken():
    here, there = Pose((0.05, 0.0, 0.04)), Pose((0.05, -0.2, 0.04))
    first, second = (Object(n, RED.shape, a, At(b)) for n, a, b in (("a", here, there), ("b", there, here)))
    ordering = Ordering(attempt(Task("swap", (first, second))), 0, time.monotonic() + 300.0, "adaptive")
    for effort in EFFORTS:
        if ordering._try_each(effort):
            break
    assert effort.others_move
    assert len(ordering.left) == 1


def test_what_would_rest_beside_another_that_is_at_its_goal_has_that_step_aside():
    lying, goal = (Pose.from_rpy((x, y, 0.015), (math.pi / 2, 0.0, 0.0)) for x, y in ((0.05, 0.25), (0.08, -0.2)))
    can = Object("can", Cylinder(0.015, 0.1), lying, At(goal))
    block = Object("block", Box((0.05, 0.05, 0.08)), Pose((0.05, -0.2, 0.04)), mass=0.3)
    ordering = Ordering(attempt(Task("beside", (can, block))), 0, time.monotonic() + 60.0, "adaptive")
    assert any(ordering._try_each(effort) for effort in EFFORTS) and not ordering.left
    assert math.dist(ordering.progress.start["can"].pose.xyz, goal.xyz) < 0.005


@pytest.mark.parametrize("tilt", [0.06, 0.0])
def test_what_would_not_stay_on_what_stands_a_little_off_is_put_where_it_comes_to_rest(tilt):
    base = Object("base", Box((0.1, 0.1, 0.04)), Pose((0.058, -0.2, 0.02)), At(Pose((0.05, -0.2, 0.02))))
    top = replace(TOP, goal=At(Pose((0.055, -0.2, 0.06))))
    now = attempt(Task("off", (base, top)))
    tilted = Placement(Pose.from_rpy((0.055, -0.2, 0.061 + 0.02 * tilt), (tilt, 0.0, 0.0)), ("base",))
    workspace = replace(now.workspace, goals={**now.workspace.goals, "top": tilted})
    search = Ordering(replace(now, workspace=workspace), 0, time.monotonic() + 30.0, "adaptive")
    search.run()
    assert not search.left and not search.progress.rejections
    assert search.progress.start["top"].pose.matrix[2, 2] > 0.9999


@pytest.mark.parametrize(("status", "drawn"), [("failed", 2), ("timeout", 1)])
def test_what_no_sample_was_of_use_for_is_asked_again_with_others(monkeypatch, status, drawn):
    seeds = set()

    def ask(self, *_, about="", **__):
        seeds.add(self.drawn_seed(about))
        return Solution(None, math.inf, status, (), Report("adaptive", status, 0.0, math.inf, {}, (), ()))

    monkeypatch.setattr(Asker, "ask", ask)
    monkeypatch.setattr(Prospects, "against", lambda self, name: None)
    ordering = Ordering(attempt(Task("one", (RED,))), 0, time.monotonic() + 600.0, "adaptive")
    for effort in EFFORTS:
        assert not ordering._try_each(effort)
    assert len(seeds) == drawn


def test_goals_that_were_tried_least_come_first(monkeypatch):
    asked = []

    def ask(self, *_, about="", **__):
        asked.append(about)
        return Solution(None, math.inf, "timeout", (), Report("adaptive", "timeout", 0.0, math.inf, {}, (), ()))

    monkeypatch.setattr(Asker, "ask", ask)
    monkeypatch.setattr(Prospects, "against", lambda self, name: None if name != "cube" or len(asked) > 1 else "time")
    ordering = Ordering(attempt(Task("three", (RED, CUBE, CLOSE))), 0, time.monotonic() + 600.0, "adaptive")
    for _ in range(2):
        ordering._try_each(EFFORTS[-1])
    assert sorted(asked[:2]) == ["close", "red"]
    assert asked[2] == "cube"


@pytest.mark.parametrize(("costly", "first"), [(False, "cube"), (True, "red")])
def test_what_another_bars_at_its_goal_comes_first_when_all_begins_again_unless_that_leaves_more(
    monkeypatch, costly, first
):
    """The cube reaches its goal only while red is not at its own, and maybe both are not found in one plan."""
    ask = Asker.ask

    def barring(self, workspace, *rest, **options):
        there = {name for name in ("red", "cube") if self.workspace.start[name] == self.workspace.goals[name]}
        asked = {name for name in workspace.goals if workspace.task.object(name).goal is not None}
        barred = "cube" in asked and "red" in there and "cube" not in there
        if barred or (costly and asked == {"red", "cube"}):
            return Solution(None, math.inf, "failed", (), Report("adaptive", "failed", 0.0, math.inf, {}, (), ()))
        return ask(self, workspace, *rest, **options)

    monkeypatch.setattr(Asker, "ask", barring)
    monkeypatch.setattr(Prospects, "against", lambda self, name: None)
    monkeypatch.setattr("tamp.pipeline.strategies.serialization.goal_order.bring_near", lambda *_: False)
    cube = replace(CUBE, goal=At(Pose((0.15, 0.2, 0.02)))) if costly else CUBE
    planning = search(Task("barred", (RED, cube)), 600.0)
    plan = planning.run()
    put = [step.object for action in plan.actions for step in action.steps if isinstance(step, Release)]
    assert put[0] == first
    assert planning.left.keys() == ({"cube"} if costly else set())


def test_what_shall_rest_on_an_object_that_is_left_near_its_goal_is_put_on_it():
    def only_top(context, obj):
        yield from from_above(context, obj) if obj == "top" else no_grasp(context, obj)

    red = replace(RED, pose=Pose((0.07, -0.2, 0.04)))
    planning = search(Task("near", (red, TOP)), 300.0, {"sample-grasp": only_top})
    plan = planning.run()
    assert not planning.left
    (put,) = [step for action in plan.actions for step in action.steps if isinstance(step, Release)]
    assert put.object == "top"
    assert put.pose.xyz[0] == pytest.approx(TOP.goal.pose.xyz[0], abs=0.001)


def test_what_the_checker_refuses_is_tried_by_way_of_another_grasp(monkeypatch):
    asked = []
    ask = Asker.ask

    def noting(self, *args, regrasped=(), **kwargs):
        asked.append(set(regrasped))
        return ask(self, *args, regrasped=regrasped, **kwargs)

    monkeypatch.setattr(Asker, "ask", noting)
    monkeypatch.setattr(Asker, "refused", lambda self, actions, about: "slides farther than it can")
    ordering = Ordering(attempt(Task("one", (RED,))), 0, time.monotonic() + 600.0, "adaptive")
    for effort in (EFFORTS[0], EFFORTS[-1], EFFORTS[-1]):
        assert not ordering._try_each(effort)
    assert ordering.left == {"red": "slides farther than it can"}
    # At first by any grasp, at last not by the one that serves both; what is asked in between is whether it can alone.
    assert asked[0] == set()
    assert asked[-1] == {"red"}


@pytest.mark.parametrize(("far", "first"), [(True, "red"), (False, "cube")])
def test_what_lies_in_a_container_near_its_goal_waits_for_what_is_far_from_its_own(monkeypatch, far, first):
    class AskedError(Exception):
        pass

    def ask(self, workspace, *_, **__):
        raise AskedError(*(obj.name for obj in workspace.task.objects if obj.goal is not None))

    cube = Object("cube", Box((0.04, 0.04, 0.04)), Pose((0.05, 0.0, 0.03)), At(Pose((0.05, 0.015, 0.03))))
    red = RED if far else replace(RED, goal=None)
    red = replace(red, pose=Pose((0.05, 0.3, 0.04)))
    monkeypatch.setattr(Asker, "ask", ask)
    ordering = Ordering(attempt(Task("crate", (CRATE, cube, red))), 0, time.monotonic() + 600.0, "adaptive")
    with pytest.raises(AskedError) as asked:
        ordering.run()
    assert asked.value.args[-1] == first
    assert list(ordering.left) == [first]


def test_what_is_at_its_goal_stays_there_while_all_that_is_left_is_tried_together(monkeypatch):
    asked = []

    def ask(self, workspace, iterations, movable, **kwargs):
        asked.append(movable)
        return Solution(None, math.inf, "failed", (), Report("adaptive", "failed", 0.0, math.inf, {}, (), ()))

    monkeypatch.setattr(Asker, "ask", ask)
    done = replace(RED, pose=RED.goal.pose)
    here = Object("here", RED.shape, Pose((0.2, 0.2, 0.04)), At(Pose((0.2, -0.3, 0.04))))
    ordering = Ordering(attempt(Task("two", (done, here))), 0, time.monotonic() + 600.0, "adaptive")
    monkeypatch.setattr(ordering, "_reach_or_bring_near", lambda: None)
    ordering.run()
    assert set(asked[-1]) == {"here"}


def test_that_goals_fail_while_what_is_at_its_own_stays_proves_nothing(monkeypatch):
    def ask(self, *args, **kwargs):
        report = Report("adaptive", "infeasible", 1.0, math.inf, {}, (), ())
        self.reports.append(report)
        return Solution(None, math.inf, "infeasible", (), report)

    monkeypatch.setattr(Asker, "ask", ask)
    done, here = replace(RED, pose=RED.goal.pose), replace(RED, name="here", goal=At(Pose((0.2, -0.3, 0.04))))
    for objects, status in (((done, here), "failed"), ((here,), "infeasible")):
        ordering = Ordering(attempt(Task("two", objects)), 0, time.monotonic() + 600.0, "adaptive")
        monkeypatch.setattr(ordering, "_reach_or_bring_near", lambda: None)
        ordering.run()
        assert ordering.report.status == status


@pytest.mark.parametrize(("tilt", "coming", "asked"), [(0.0, True, True), (0.5, True, False), (0.5, False, True)])
def test_what_nothing_holds_at_its_goal_waits_for_others_that_may_though_a_simulator_leaves_it_there(
    monkeypatch, tilt, coming, asked
):
    """Where none is to come any more, there is nothing to wait for."""
    goal = Pose.from_rpy((0.05, -0.2, 0.04), (tilt, 0.0, 0.0))
    begin = attempt(Task("held", (replace(RED, goal=At(goal)), CUBE)))
    place, beside = Placement(goal, ("table",)), Placement(Pose((0.05, -0.26, 0.02)), ("table",))
    start = begin.workspace.start if coming else {**begin.workspace.start, "cube": beside}
    begin = replace(begin, workspace=replace(begin.workspace, start=start, goals={"red": place, "cube": beside}))
    ordering = Ordering(begin, 0, time.monotonic() + 600.0, "adaptive")
    stays = replace(begin.workspace, start={**start, "red": place})
    monkeypatch.setattr(goal_stability, "rest_from_goal", lambda *_: stays)
    monkeypatch.setattr(GoalStability, "uncertain", lambda *_: True)
    questions = []

    def ask(asker, *args, ask=Asker.ask, **options):
        questions.append(args)
        return ask(asker, *args, **options)

    monkeypatch.setattr(Asker, "ask", ask)
    ordering._try_each(EFFORTS[0], {"cube"})
    assert bool(questions) is asked
    assert asked or ordering.left["red"] == "it does not stay there before others come"


def test_what_would_tip_what_carries_it_is_not_asked_for_again_before_others_come(monkeypatch):
    """A weight on one end of a plank that only another one, on the other end, keeps level."""
    post = Object("post", Box((0.06, 0.06, 0.04)), Pose((0.0, -0.3, 0.02)))
    plank = Object("plank", Box((0.3, 0.06, 0.02)), Pose((0.0, -0.3, 0.05)))
    weights = [
        Object(
            f"weight{side}", Box((0.04, 0.04, 0.04)), Pose((side * 0.1, 0.2, 0.02)), At(Pose((side * 0.12, -0.3, 0.08)))
        )
        for side in (-1, 1)
    ]
    begin = attempt(Task("scales", (post, plank, *weights)))
    ordering, questions = Ordering(begin, 0, time.monotonic() + 600.0, "adaptive"), []

    def ask(asker, workspace, *args, ask=Asker.ask, **options):
        questions.append([*workspace.goals])
        return ask(asker, workspace, *args, **options)

    monkeypatch.setattr(Asker, "ask", ask)
    for effort in EFFORTS[:2]:
        ordering._try_each(effort, {"weight1"})
    assert questions == [["weight-1", "weight1"], ["weight-1"]], "whether it reaches its goal if it is alone"
    assert ordering.left["weight-1"].endswith("plank, post would tip")
