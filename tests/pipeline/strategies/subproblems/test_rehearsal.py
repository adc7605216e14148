from __future__ import annotations

import math
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.checking import Problem, Verdict
from tamp.execution.log import Deviation
from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.partial_plan import INEXACT, Progress, _learn_met
from tamp.pipeline.strategies.subproblems.plan_state import after, begins_at
from tamp.pipeline.strategies.subproblems.rehearsal import among_few, uncertain_parts
from tamp.pipeline.strategies.subproblems.subproblem import Asker
from tamp.streams.affordances.falls import refused
from tamp.streams.cache import SampleCache
from tamp.streams.motion.handling_contacts import DISTURBING, disturbs, learn_disturbed
from tamp.streams.values import Handling, Placement
from tamp.task import Action, Attachment, Box, Fall, Grip, Object, Plan, Pose, Release, load_robot
from tamp.task.files.load import load_task
from tamp.world.geometry.object_geometry import load_geometry
from tamp.world.robot.model import robot_model
from tamp.world.world import World

SCENARIOS = Path(__file__).parents[4] / "scenarios"


@pytest.fixture(scope="module")
def fallen():
    """A state, and a plan from there in which a book is laid down."""
    return planned("lay_book")


def planned(scenario):
    setup = prepare(load_task(SCENARIOS / f"{scenario}.yaml"))
    state = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    plan = Asker(Progress(state), 0, time.monotonic() + 600.0, "adaptive").ask(state.workspace, 30, None).plan
    assert plan
    return state, plan


def rehearsing(monkeypatch, status, off=(0.07, 0.99)):
    """Let rehearsals end with a status; the list of what is rehearsed."""
    rehearsed = []

    def execute(task, plan, **how):
        rehearsed.append(plan)
        return SimpleNamespace(status=status, deviation=Deviation("book", "misplaced", *off))

    monkeypatch.setattr("tamp.pipeline.strategies.subproblems.rehearsal.execute", execute)
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


@pytest.mark.parametrize(
    ("kind", "nearer", "taken"), [("misplaced", True, True), ("misplaced", False, False), ("disturbed", True, False)]
)
def test_what_is_brought_near_may_come_to_rest_in_another_way_if_only_that_is_better(
    fallen, monkeypatch, kind, nearer, taken
):
    state, plan = fallen
    there = {name: state.workspace.goals[name].pose for name in state.workspace.goals}
    ends = there if nearer else {name: state.workspace.start[name].pose for name in there}
    deviation = Deviation(next(iter(there)), kind, 0.07, 0.99)
    run = SimpleNamespace(status="deviated", deviation=deviation, final_poses=ends)
    monkeypatch.setattr("tamp.pipeline.strategies.subproblems.rehearsal.execute", lambda *_, **__: run)
    assert Progress(state).take(plan, 0) is not None
    assert (Progress(state).take(plan, 0, near=True) is None) == taken


def test_what_goes_as_planned_in_the_simulator_is_taken(fallen):
    state, plan = fallen
    assert Progress(state).take(plan, 0) is None


def test_a_piece_in_which_nothing_falls_is_not_rehearsed(monkeypatch):
    rehearsed = rehearsing(monkeypatch, "deviated")
    state, plan = planned("one_object")
    assert Progress(state, unsteady=["another"]).take(plan, 0) is None
    assert not rehearsed


def test_what_has_ended_elsewhere_again_and_again_is_rehearsed_though_nothing_falls(monkeypatch):
    rehearsed = rehearsing(monkeypatch, "deviated")
    state, plan = planned("one_object")
    (name,) = state.workspace.goals
    assert Progress(state, unsteady=[name]).take(plan, 0) == "rehearsed: book misplaced: off by 70.0 mm and 0.99 rad"
    assert len(rehearsed) == 1


def errand(number, falls):
    name, there = f"thing{number}", Pose((0.1 * number, 0.0, 0.0))
    let_go = (Release(name, there, 0.08), *([Fall(name, there)] if falls else []))
    move = Action("move", (), ())
    return [
        move,
        Action("pick", (name,), (Grip(Attachment(name, Pose((0.0, 0.0, 0.0))), 0.02),)),
        Action("move", (name,), ()),
        Action("lay" if falls else "place", (name,), let_go),
    ]


@given(st.lists(st.booleans(), max_size=8))
def test_a_rehearsal_is_of_whole_errands_those_uncertain_parts_and_no_move_before_them(falls):
    start = {f"thing{i}": Pose((0.0, 1.0, 0.0)) for i in range(len(falls))}
    home = load_robot("panda").home
    actions = tuple(action for i, each in enumerate(falls) for action in errand(i, each))
    plan = Plan("shelf", "panda", 0, start, home, {}, actions)
    parts = [part for _, part in uncertain_parts(robot_model(load_robot("panda")), plan)]
    rehearsed = [action.arguments[0] for part in parts for action in part.actions if action.name in ("lay", "place")]
    assert rehearsed == [f"thing{i}" for i, each in enumerate(falls) if each]
    for part in parts:
        first = plan.actions.index(part.actions[0])
        state = after(robot_model(load_robot("panda")), replace(plan, actions=plan.actions[:first]))
        assert part.actions[0].name == "pick" and begins_at(part, state)


def test_what_is_far_from_all_that_moves_is_not_in_a_rehearsal_and_what_is_beside_it_is(fallen):
    state, plan = fallen
    piece = state.timed(plan, 0, {})
    ((last, part),) = uncertain_parts(state.setup.world.robot, piece)
    assert piece.actions[last] == part.actions[-1]
    moved = next(step.object for step in part.steps if isinstance(step, Fall))
    end = after(state.setup.world.robot, part).start[moved]
    table, box = state.setup.task.table, Box((0.05, 0.05, 0.05))
    corners = [(table.center[0] + x * 0.35, table.center[1] + y * 0.5) for x in (-1, 1) for y in (-1, 1)]
    far = max(corners, key=lambda at: min(math.dist(at, pose.xyz[:2]) for pose in (part.start[moved], end)))
    extra = {"beside": Pose((end.xyz[0], end.xyz[1], 0.3)), "far": Pose((*far, 0.025)), "on far": Pose((*far, 0.075))}
    setup = replace(
        state.setup,
        task=replace(
            state.setup.task,
            objects=(*state.setup.task.objects, *(Object(name, box, pose) for name, pose in extra.items())),
        ),
        world=World(
            state.setup.world.robot,
            {**state.setup.world.geometries, **{name: load_geometry(box) for name in extra}},
            table,
        ),
    )
    task, kept = among_few(setup, replace(part, start={**part.start, **extra}))
    names = {item.name for item in task.objects}
    assert names == {*kept.start} and {moved, "beside"} <= names and names.isdisjoint({"far", "on far"})


def test_a_tilted_release_that_the_checker_refuses_is_not_planned_again(monkeypatch):
    state, plan = planned("lay_book")
    last, handling = len(plan) - 1, plan[-1].args[-1]
    wrong = Problem(last, "lay(book, table)", 0.0, "fall", ("book",), 0.0, "book slides on")
    monkeypatch.setattr(Attempt, "checked", lambda self, piece: Verdict(problems=(wrong,)))
    assert Progress(state).take(plan, 0)
    again = Asker(Progress(state), 0, time.monotonic() + 600.0, "adaptive").ask(state.workspace, 30, None).plan
    assert again is None or again[-1].args[-1].let_go != handling.let_go


@pytest.mark.parametrize(
    ("bodies", "depth", "barred"),
    [(("other", "book"), 0.0, True), (("other", "book"), 0.0012, False), (("book",), 0.0, False)],
)
def test_only_a_fall_that_upsets_another_is_barred_wherever_it_ends_on_the_same_things(
    fallen, monkeypatch, bodies, depth, barred
):
    """Where something is met on the way down, or the object itself does not stay, it may fall near by."""
    state, plan = fallen
    state, way = replace(state, workspace=replace(state.workspace, cache=SampleCache())), plan[-1].args[-1]
    wrong = Problem(len(plan) - 1, "lay(book, table)", 0.0, "fall", bodies, depth, "a fall goes wrong")
    monkeypatch.setattr(Attempt, "checked", lambda self, piece: Verdict(problems=(wrong,)))
    assert Progress(state).take(plan, 0)
    aside = Pose((0.01, 0.0, 0.0))
    elsewhere = replace(way.placement, pose=aside @ way.placement.pose)
    assert refused(state.workspace, way.object, elsewhere, aside @ way.let_go) == barred


def test_what_a_rehearsal_has_come_down_elsewhere_is_not_let_go_so_again(fallen, monkeypatch):
    (state, plan), _ = fallen, rehearsing(monkeypatch, "deviated")
    handling = plan[-1].args[-1]
    state = replace(state, workspace=replace(state.workspace, cache=SampleCache()))
    assert Progress(state).take(plan, 0)
    again = Asker(Progress(state), 0, time.monotonic() + 600.0, "adaptive").ask(state.workspace, 30, None).plan
    assert again is None or again[-1].args[-1].let_go != handling.let_go


def test_an_object_that_disturbs_another_in_a_few_ways_waits_for_that_to_go(fallen):
    state, plan = fallen
    handling, standing = plan[-1].args[-1], Placement(Pose((0.5, 0.5, 0.0)), ("table",))
    workspace = replace(state.workspace, cache=SampleCache())
    ways = [replace(handling, fall=(Pose((0.0, 0.0, z)), *handling.fall[1:])) for z in (0.2, 0.3, 0.4, 0.5)]
    for number, way in enumerate(ways):
        assert disturbs(workspace, way, "other", standing) == (number >= DISTURBING)
        for _ in range(DISTURBING):  # it is one way all the same
            learn_disturbed(workspace, way, "other", standing)
        assert disturbs(workspace, way, "other", standing)
    elsewhere = Placement(Pose((0.6, 0.5, 0.0)), ("table",))
    assert not disturbs(workspace, ways[0], "other", elsewhere)


def test_what_meets_another_as_it_is_taken_may_be_taken_by_another_grasp(fallen):
    """Closing pads turn it into that one: by which grasp it is let go does not matter."""
    state, plan = fallen
    way, other = plan[-1].args[-1], Placement(Pose((0.5, 0.5, 0.0)), ("table",))
    regrasped = replace(way, grasp=replace(way.grasp, width=way.grasp.width + 0.001))
    for standing, met in (({"other": other}, True), ({"other": other, way.object: way.placement}, False)):
        workspace = replace(state.workspace, cache=SampleCache())
        _learn_met(workspace, way, (way.object, "other"), standing)
        assert disturbs(workspace, way, "other", other)
        assert disturbs(workspace, regrasped, "other", other) == met


@pytest.mark.parametrize(("distance", "angle", "taken"), [(0.015, 0.3, True), (0.035, 0.3, False), (0.015, 0.6, False)])
def test_what_can_be_corrected_is_taken_once_more_exact_ways_were_sought(fallen, monkeypatch, distance, angle, taken):
    (state, plan), _ = fallen, rehearsing(monkeypatch, "deviated", (distance, angle))
    progress = Progress(state)
    tried = [progress.take(plan, 0) is None for _ in range(INEXACT + 1)]
    assert tried == [False] * INEXACT + [taken]


def test_what_is_not_laid_down_tilted_is_taken_at_once_where_it_can_be_corrected(fallen, monkeypatch):
    (state, plan), _ = fallen, rehearsing(monkeypatch, "deviated", (0.015, 0.3))
    piece = state.timed(plan, 0, {})
    monkeypatch.setattr(Attempt, "timed", lambda *_: piece)
    monkeypatch.setattr(Handling, "laid", False)
    assert Progress(state).take(plan, 0) is None
