from __future__ import annotations

import math
import time
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tamp.checking import Problem, Verdict
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.serialization import nearest_placement as nearness
from tamp.pipeline.strategies.serialization.nearest_placement import (
    KEPT,
    Grips,
    bring_near,
    bring_to_rest,
    rest_from_goal,
)
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.goal_graph import nearly_there
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.pipeline.strategies.subproblems.subproblem import EFFORTS, Asker
from tamp.scoring.ede import ede, mean_edge
from tamp.streams.values import Placement, Slide
from tamp.task import At, Box, Mesh, Object, Pose, Task, load_robot
from tests.pipeline.samplers import no_grasp
from tests.streams.tables import OBJECTS

CUBE = Box((0.05, 0.05, 0.05))
RED = Object("red", CUBE, Pose((0.1, 0.1, 0.025)))
TOP = Object("top", CUBE, Pose((0.1, 0.1, 0.075)))
WIDE = Object("wide", Box((0.12, 0.12, 0.04)), Pose((0.1, 0.1, 0.02)))
THERE = Placement(Pose((0.1, -0.2, 0.026)), ("table",))


def grips(*objects, samplers=None):
    setup = prepare(Task("grips", objects))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, samplers)
    return Grips(attempt.workspace, objects[0].name, attempt.samplers, 0, math.inf)


def test_what_can_be_taken_can_be_put_to_a_free_place():
    red = grips(RED)
    assert 0 < len(red.grasps) <= KEPT
    serving = red.serving(THERE)
    assert serving
    assert set(serving) <= set(red.roomy(THERE)) <= set(red.grasps)


def test_the_same_seed_finds_the_same():
    assert grips(RED).grasps == grips(RED).grasps


def test_beside_a_wall_on_every_side_there_is_no_room():
    x, y, _ = THERE.pose.xyz
    walls = [
        Object(f"wall-{n}", Box((0.02, 0.3, 0.3) if dx else (0.15, 0.02, 0.3)), Pose((x + dx, y + dy, 0.15)))
        for n, (dx, dy) in enumerate(((0.1, 0.0), (-0.1, 0.0), (0.0, 0.05), (0.0, -0.05)))
    ]
    red = grips(RED, *walls)
    assert red.grasps
    assert red.serving(THERE) == ()


def test_nothing_takes_what_carries_others_or_is_too_wide_or_nobody_grasps():
    assert grips(RED, TOP).grasps == ()
    assert grips(WIDE).grasps == ()
    assert grips(RED, samplers={"sample-grasp": no_grasp}).grasps == ()


def test_a_hand_from_above_fits_as_the_object_stands_and_not_upside_down():
    red = grips(Object("red", Box((0.05, 0.05, 0.02)), Pose((0.1, 0.1, 0.01))))
    assert red.grasps
    assert red.fits(np.eye(3))
    assert not red.fits(np.diag([1.0, -1.0, -1.0]))


def test_what_finds_no_room_for_the_hand_in_a_crate_may_be_dropped_into_it():
    crate = Object("crate", Mesh(OBJECTS / "open_box" / "collision.obj", 1.5), Pose((0.10, -0.22, 0.045)))
    block = grips(Object("block", Box((0.04, 0.05, 0.03)), Pose((0.05, 0.2, 0.015))), crate)
    assert block.serving(Placement(Pose((0.012, -0.352, 0.022)), ("crate",)))
    assert not block.serving(Placement(Pose((0.012, -0.352, 0.022)), ("table",)))


BLOCK = Object("block", Box((0.16, 0.16, 0.1)), Pose((0.1, 0.25, 0.05)), At(Pose((0.1, 0.0, 0.05))))
"""No hand takes it, so that what shall rest on it never can."""
SLAB = Object("slab", Box((0.12, 0.16, 0.03)), Pose((0.0, -0.4, 0.015)), At(Pose((0.1, 0.0, 0.115))))
TURNED_SLAB = replace(SLAB, goal=At(Pose.from_rpy((0.1, 0.0, 0.115), (0.0, 0.0, 1.2))))
NEARNESS_CUBE = Object("cube", Box((0.05, 0.05, 0.05)), Pose((0.0, -0.2, 0.025)), At(Pose((0.1, 0.0, 0.125))))


def asker_of(*objects):
    setup = prepare(Task("near", objects))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    return Asker(Progress(attempt), seed=0, deadline=time.monotonic() + 600.0, algorithm="adaptive")


@pytest.mark.parametrize(
    ("obj", "actions"), [(NEARNESS_CUBE, {"pick", "place"}), (SLAB, {"slide"}), (TURNED_SLAB, {"slide", "pick"})]
)
def test_what_cannot_rest_where_it_shall_is_brought_near_even_if_it_has_to_be_slid_first(obj, actions):
    asker = asker_of(BLOCK, obj)
    assert bring_near(asker, {obj.name}, set())
    here = asker.workspace.start[obj.name].pose
    assert ede(mean_edge(obj.shape), here, obj.goal.pose) < 0.15
    assert actions <= {action.name for action in asker.progress.actions}


TALL = Box((0.05, 0.05, 0.1))
TURNED = Object("tall", TALL, Pose((0.0, -0.2, 0.05)), At(Pose.from_rpy((0.1, 0.0, 0.15), (np.pi, 0.0, 0.0))))


HUGE_GOAL = At(Pose.from_rpy((0.0, 0.2, 0.05), (math.pi, 0.0, 0.3)))
HUGE = Object("huge", Box((0.16, 0.16, 0.1)), Pose((0.0, -0.2, 0.05)), HUGE_GOAL)


def test_what_no_hand_gets_hold_of_anywhere_is_pushed_near():
    """All of its sides are wider than the hand opens, so that nothing is asked that only a hand could do."""
    asker = asker_of(HUGE)
    before = ede(0.16, asker.workspace.start["huge"].pose, HUGE_GOAL.pose)
    assert bring_near(asker, {"huge"}, ())
    assert {action.name for action in asker.progress.actions} == {"move", "slide"}
    assert ede(0.16, asker.workspace.start["huge"].pose, HUGE_GOAL.pose) < before - 0.1
    assert len(asker.reports) == 1


def test_a_push_that_the_checker_refuses_is_not_planned_again(monkeypatch):
    asker, planned, ask = asker_of(HUGE), list[Slide](), Asker.ask

    def asked(*args, **options):
        solution = ask(*args, **options)
        planned.extend(value for action in solution.plan for value in action.args if isinstance(value, Slide))
        return solution

    tips = Problem(1, "slide(huge, table)", 0.0, "push", ("huge",), 0.0, "huge would tip over")
    monkeypatch.setattr(Attempt, "checked", lambda *_: Verdict((tips,)))
    monkeypatch.setattr(Asker, "ask", asked)
    assert not bring_near(asker, {"huge"}, ())
    assert not bring_near(asker, {"huge"}, ())
    pushes = [(slide.end, slide.T_tool_object) for slide in planned]
    assert pushes and len({*pushes}) == len(pushes)


def test_what_two_grasps_have_to_turn_over_is_turned_over_on_its_way_near():
    asker = asker_of(BLOCK, TURNED)
    assert bring_near(asker, {"tall"}, set())
    assert [action.name for action in asker.progress.actions].count("place") == 2
    assert asker.workspace.start["tall"].pose.matrix[2, 2] < -0.99


@pytest.mark.parametrize(("tilt", "brought"), [(0.06, True), (0.0, False)])
def test_what_does_not_stay_at_its_goal_alone_is_put_where_it_comes_to_rest_from_there(tilt, brought):
    asker = asker_of(replace(RED, goal=At(Pose((0.1, -0.2, 0.025)))))
    now = asker.progress.now
    tilted = Placement(Pose.from_rpy((0.1, -0.2, 0.025 + 0.025 * tilt), (tilt, 0.0, 0.0)), ("table",))
    asker.progress.now = replace(now, workspace=replace(now.workspace, goals={"red": tilted}))
    there = rest_from_goal(asker, "red")
    assert there is not None and bring_to_rest(asker, "red", there, set(), set(), EFFORTS[0]) == brought
    assert (nearly_there(asker.workspace, "red"), bool(asker.progress.actions)) == (brought, brought)
    assert asker.workspace.start["red"].pose.matrix[2, 2] > 0.9999


@pytest.mark.parametrize(
    ("height", "on", "effort", "brought"),
    [
        (0.075, "red", EFFORTS[0], True),
        (0.06, "red", EFFORTS[0], False),
        (0.06, "red", EFFORTS[1], True),
        (0.06, "table", EFFORTS[1], False),
        (0.06, "table", EFFORTS[2], True),
    ],
)
def test_what_would_rest_where_another_shall_be_waits_for_that_at_its_goal(height, on, effort, brought):
    """Not for what it shall carry, once others are moved: that has nothing else to rest on."""
    asker = asker_of(replace(RED, goal=At(Pose((0.1, -0.2, 0.025)))), Object("top", CUBE, Pose((-0.1, 0.1, 0.025))))
    now = asker.progress.now
    tilted = Placement(Pose.from_rpy((0.1, -0.2, 0.0265), (0.06, 0.0, 0.0)), ("table",))
    goals = {"red": tilted, "top": Placement(Pose((0.1, -0.2, height)), (on,))}
    asker.progress.now = replace(now, workspace=replace(now.workspace, goals=goals))
    there = rest_from_goal(asker, "red")
    assert bring_to_rest(asker, "red", there, set(), set(), effort) == brought


@pytest.mark.parametrize("effort", EFFORTS[:2])
def test_what_is_in_its_way_there_moves_with_the_greater_efforts_only(effort):
    """A cube on top keeps the other from being taken to where it comes to rest from a tilted goal."""
    asker = asker_of(replace(RED, goal=At(Pose((0.1, -0.2, 0.025)))), TOP)
    now = asker.progress.now
    tilted = Placement(Pose.from_rpy((0.1, -0.2, 0.0265), (0.06, 0.0, 0.0)), ("table",))
    asker.progress.now = replace(now, workspace=replace(now.workspace, goals={"red": tilted}))
    there = rest_from_goal(asker, "red")
    assert bring_to_rest(asker, "red", there, set(), set(), effort) == effort.others_move
    assert nearly_there(asker.workspace, "red") == effort.others_move


def test_what_nothing_comes_of_leaves_time_to_the_others(monkeypatch):
    """On a clock on which each of three objects uses all the time that it is given."""
    time, given = [0.0], []

    def in_vain(asker, name, *_):
        given.append((name, asker.deadline - time[0]))
        time[0] = asker.deadline
        return False

    monkeypatch.setattr("tamp.clock.now", lambda: time[0])
    monkeypatch.setattr(nearness, "farthest_first", lambda workspace, names: sorted(names))
    monkeypatch.setattr(nearness, "_bring_near", in_vain)
    asker = Asker(SimpleNamespace(now=SimpleNamespace(workspace=None)), seed=0, deadline=24.0, algorithm="adaptive")
    assert not bring_near(asker, {"a", "b", "c"}, ())
    assert given == [("a", 12.0), ("b", 6.0), ("c", nearness.LEAST)]
    assert asker.deadline == 24.0


def looked_into(monkeypatch, places, serves, refused=(), unstable=()):
    """The places that the planner is asked for in vain, each with how many grasps, and those that are looked at.

    The checker sends back what comes to those that are `refused`, and would have nothing stay at those `unstable`.
    """
    asked, looked, rejections = [], [], []

    def serving(place):
        looked.append(place)
        return ("grasp",) * (place in serves)

    grips = SimpleNamespace(grasps=("grasp",), fits=None, roomy=lambda place: ("grasp",), serving=serving)
    monkeypatch.setattr(nearness, "Grips", lambda *args: grips)
    monkeypatch.setattr(nearness, "turned_over", lambda *args: False)
    monkeypatch.setattr(nearness, "substitutes", lambda *args: iter(places))

    def put(asker, name, place, kept, grasps):
        asked.append((place, len(grasps)))
        rejections.extend(["sent back"] * (place in refused))

    monkeypatch.setattr(nearness, "_put", put)
    asker = SimpleNamespace(
        workspace=None, drawn_seed=lambda name: 0, deadline=1.0, late=False, within=lambda share: nullcontext()
    )
    now = SimpleNamespace(
        samplers={}, setup=SimpleNamespace(settings=Settings()), stays=lambda _, place: place not in unstable
    )
    asker.progress = SimpleNamespace(now=now, rejections=rejections)
    assert not nearness._bring_near(asker, "object", (), ())
    return asked, looked


def test_where_time_is_up_for_the_nearest_places_the_table_is_left(monkeypatch):
    """What is under way to nowhere takes its share of the time, and no more."""
    table = [Placement(Pose((x, 0.0, 0.025)), ("table",)) for x in (0.12, 0.13, 0.2)]
    time, asked = [0.0], []

    def settling(*args):
        time[0] += 9.0
        yield inside(0.0)

    grips = SimpleNamespace(
        grasps=("g",), fits=None, roomy=lambda place: (), serving=lambda place: table[2:].count(place)
    )
    monkeypatch.setattr("tamp.clock.now", lambda: time[0])
    monkeypatch.setattr(nearness, "Grips", lambda *args: grips)
    monkeypatch.setattr(nearness, "turned_over", lambda *args: False)
    monkeypatch.setattr(nearness, "substitutes", settling)
    monkeypatch.setattr(nearness, "on_table", lambda *args: table)
    monkeypatch.setattr(nearness, "_put", lambda asker, name, place, kept, grasps: asked.append(place) or True)
    state = SimpleNamespace(
        workspace=None,
        samplers={},
        setup=SimpleNamespace(settings=Settings()),
        stays=lambda *_: True,
    )
    asker = Asker(SimpleNamespace(now=state, rejections=[]), seed=0, deadline=10.0, algorithm="adaptive")
    assert nearness._bring_near(asker, "object", (), ())
    assert asked == [table[2]]


def inside(x, roll=0.0):
    return Placement(Pose.from_rpy((x, 0.0, 0.1), (roll, 0.0, 0.0)), ("crate",))


def test_where_a_hand_can_put_it_is_tried_before_where_nobody_knows(monkeypatch):
    unknown, known = inside(0.0), inside(0.1)
    assert looked_into(monkeypatch, [unknown, known], [known])[0] == [(known, 1), (unknown, 0)]


def test_a_face_on_which_the_arm_cannot_put_it_is_not_looked_at_for_ever(monkeypatch):
    on_one_face, on_another = [inside(0.01 * i) for i in range(9)], inside(0.2, roll=1.0)
    looked = looked_into(monkeypatch, [*on_one_face, on_another], [on_another])[1]
    assert looked == [*on_one_face[: nearness.VAIN], on_another]


def test_what_the_checker_sends_back_is_not_put_beside_there_on_the_same(monkeypatch):
    in_crate, elsewhere = [inside(0.01 * i) for i in range(3)], replace(inside(0.3), on=("shelf",))
    places = [*in_crate, elsewhere]
    asked, _ = looked_into(monkeypatch, places, places, refused=in_crate)
    assert [place for place, _ in asked] == [in_crate[0], elsewhere]


def test_where_the_checker_would_not_have_it_stay_is_not_asked_for(monkeypatch):
    slipping, hidden, steady = (inside(0.1 * i) for i in range(3))
    looked = looked_into(monkeypatch, [slipping, hidden, steady], [slipping, steady], unstable=[slipping, hidden])
    assert looked == ([(steady, 1)], [steady])


def test_where_others_shall_be_is_kept_free():
    setup = prepare(Task("near", (BLOCK, NEARNESS_CUBE)))
    workspace = Attempt.of(setup, setup.start, load_robot("panda").home, None).workspace
    there, beside = (Placement(Pose((x, 0.0, 0.025)), ("table",)) for x in (0.12, -0.1))
    assert nearness._covers(workspace, "cube", there, {"block"})
    assert not nearness._covers(workspace, "cube", beside, {"block"})
    assert not nearness._covers(workspace, "cube", there, ())
