"""Plans after which things would tip, roll or sink, or that start so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking import check
from tamp.checking.physics.stacks import off_balance, stack_of, upset
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import At, Box, Capsule, Fall, Inertia, Object, Plan, Pose, Sphere, Task
from tests.checking.handmade import Hand, alone, carry, two_boxes
from tests.checking.judging import kinds
from tests.checking.mutations.editing import shifted


def test_a_plank_between_counterweights_tips_when_one_is_taken():
    plank = Object("plank", Box((0.3, 0.05, 0.02)), Pose((0.05, 0.0, 0.07)))
    block = Object("block", Box((0.05, 0.05, 0.06)), Pose((0.05, 0.0, 0.03)))
    weights = [
        Object(name, Box((0.04, 0.04, 0.06)), Pose((0.05 + side * 0.12, 0.0, 0.11)), mass=0.4)
        for name, side in (("red", -1), ("green", 1))
    ]
    goal = Pose((0.05, 0.25, 0.03))
    weights[0] = replace(weights[0], goal=At(goal))
    task = Task("scales", (block, plank, *weights))
    home = two_boxes()[1].home
    actions = carry(Hand(home), "red", weights[0].pose, goal, 0.04, ("plank", "table"))
    plan = Plan("scales", "panda", 0, {o.name: o.pose for o in task.objects}, home, {"red": goal}, tuple(actions))
    assert check(task, replace(plan, actions=()), goals={"red": goal}).problems[0].kind == "goal"  # it starts at rest
    found = [p for p in check(task, plan).problems if p.kind == "precondition"]
    assert any("when red is taken away" in p.sentence for p in found)


def on_a_board(x: float, goal: Pose | None) -> tuple[Task, Plan]:
    """A board on a block 4 cm long gets a weight of 0.2 kg so far out, or loses the counterweight of one that is there.

    What is left on the board, or comes, takes the common centre of mass two thirds as far out.
    """
    out, level = Pose((0.05 + x, -0.1, 0.066)), Pose((0.0, -0.1, 0.066))
    taken = goal is not None
    start, goal = (level, goal) if goal is not None else (Pose((0.05, 0.2, 0.03)), out)
    things = [
        Object("block", Box((0.04, 0.04, 0.03)), Pose((0.05, -0.1, 0.015)), mass=1.0),
        Object("board", Box((0.16, 0.04, 0.006)), Pose((0.05, -0.1, 0.033)), mass=0.1),
        Object("red", Box((0.03, 0.04, 0.06)), start, At(goal), mass=0.1 if taken else 0.2),
    ]
    if taken:
        things.append(Object("weight", Box((0.03, 0.04, 0.06)), out, mass=0.2))
    home = two_boxes()[1].home
    actions = carry(Hand(home), "red", start, goal, 0.04, ("board", "table") if taken else ("table", "board"))
    task = Task("board", tuple(things))
    return task, Plan("board", "panda", 0, {o.name: o.pose for o in things}, home, {"red": goal}, tuple(actions))


@pytest.mark.parametrize("goal", [None, Pose((0.05, 0.2, 0.03))])
@pytest.mark.parametrize(("x", "wrong"), [(0.0305, True), (0.03, True), (0.0295, False)])
def test_a_load_on_the_edge_of_what_carries_it_tips_with_all_that_bears_it(x, wrong, goal):
    """A third of a millimetre beyond, and over the very edge, all of it fell in two simulators."""
    found = [problem.sentence for problem in check(*on_a_board(x, goal)).problems]
    assert any("its load is on the edge of what carries it" in sentence for sentence in found) == wrong, found
    assert bool(found) == wrong, found


@given(
    at=st.tuples(st.floats(-0.13, -0.03), st.floats(0.03, 0.13)),
    masses=st.tuples(st.floats(0.05, 1), st.floats(0.05, 1)),
)
@settings(max_examples=25, deadline=None)
def test_scales_balance_as_their_moments_say(at, masses):
    width, thickness = 0.05, 0.02
    block = Object("block", Box((width, 0.05, 0.06)), Pose((0.0, 0.0, 0.03)))
    plank = Object("plank", Box((0.3, 0.05, thickness)), Pose((0.0, 0.0, 0.07)), mass=0.1)
    weights = [
        Object(f"weight {x}", Box((0.03, 0.03, 0.06)), Pose((x, 0.0, 0.11)), mass=m)
        for x, m in zip(at, masses, strict=True)
    ]
    task = Task("scales", (block, plank, *weights))
    state = State({o.name: o.pose.matrix for o in task.objects}, np.zeros(7))
    scene = Scene.of(task)
    off = off_balance(scene, state, stack_of(scene, state, "plank", DEFAULT))
    outside = abs(sum(m * x for x, m in zip(at, masses, strict=True)) / (sum(masses) + 0.1)) - width / 2
    if abs(outside) > 0.001:
        assert (outside > 0) == bool(off)


def test_a_weight_set_on_the_end_of_a_plank_tips_it():
    plank = Object("plank", Box((0.3, 0.05, 0.02)), Pose((0.05, 0.0, 0.07)))
    block = Object("block", Box((0.05, 0.05, 0.06)), Pose((0.05, 0.0, 0.03)))
    red = Object("red", Box((0.04, 0.04, 0.06)), Pose((0.05, 0.25, 0.03)), At(Pose((0.17, 0.0, 0.11))), mass=0.4)
    task = Task("scales", (block, plank, red))
    home = two_boxes()[1].home
    actions = carry(Hand(home), "red", red.pose, red.goal.pose, 0.04, ("table", "plank"))
    plan = Plan(
        "scales", "panda", 0, {o.name: o.pose for o in task.objects}, home, {"red": red.goal.pose}, tuple(actions)
    )
    found = [p for p in check(task, plan).problems if p.kind == "support"]
    assert any("plank tips over" in p.sentence for p in found)


@pytest.mark.parametrize(
    ("half", "radius", "friction", "masses", "wrong"),
    [(0.0188, 0.0224, 0.2, (0.097, 0.165), True), (0.0132, 0.0202, 0.7, (0.2, 0.4), False)],
)
def test_what_lies_across_a_gap_pushes_apart_what_carries_it(half, radius, friction, masses, wrong):
    """In two simulators the first comes down by 60 mm, and the other stays; the sides of the blocks held both up."""
    height, wide = 1.5 * radius, 0.05
    places = [Pose((0.05, side * (half + wide / 2), height / 2)) for side in (-1, 1)]
    blocks = [Object(f"block {T.xyz[1]}", Box((0.1, wide, height)), T, mass=masses[1]) for T in places]
    ball = Object("ball", Sphere(radius), Pose((0.05, 0.0, height + (radius**2 - half**2) ** 0.5)), mass=masses[0])
    task = Task("gap", tuple(replace(thing, friction=friction) for thing in (*blocks, ball)))
    state = State({o.name: o.pose.matrix for o in task.objects}, np.zeros(7))
    said = [sentence for sentence, *_ in upset(Scene.of(task), state.without("ball"), state, ["ball"], DEFAULT)]
    assert any("ball slides" in sentence for sentence in said) == wrong, said


def test_what_leans_on_a_face_falls_when_that_leaves():
    tilt, thick, high = 0.3, 0.02, 0.12
    reach = (high * np.sin(tilt) + thick * np.cos(tilt)) / 2
    height = (high * np.cos(tilt) + thick * np.sin(tilt)) / 2
    wall = Object(
        "wall", Box((0.04, 0.1, 0.14)), Pose((reach + 0.02, 0.0, 0.07)), At(Pose((0.05, 0.3, 0.07))), mass=1.0
    )
    board = Object("board", Box((thick, 0.08, high)), Pose.from_rpy((0.0, 0.0, height), (0.0, tilt, 0.0)), friction=1.0)
    task = Task("leaning", (wall, board))
    home = two_boxes()[1].home
    actions = carry(Hand(home), "wall", wall.pose, wall.goal.pose, 0.04, ("table", "table"), grip_height=0.06)
    plan = Plan(
        "leaning", "panda", 0, {o.name: o.pose for o in task.objects}, home, {"wall": wall.goal.pose}, tuple(actions)
    )
    said = [problem.sentence for problem in check(task, plan).problems]
    assert any("board leans on wall" in sentence for sentence in said), said


def test_nothing_stands_in_the_table():
    task, plan = alone(Box((0.05, 0.05, 0.08)), Pose((0.05, -0.2, 0.04)), Pose((0.05, 0.2, 0.0365)), 0.05)
    assert "support" in kinds(task, plan)


@pytest.mark.parametrize(("inside", "stays"), [(0.003, False), (0.015, True)])
def test_what_falls_on_the_verge_of_tipping_does_not_stay(inside, stays):
    block = Object("block", Box((0.1, 0.1, 0.04)), Pose((0.05, 0.2, 0.02)))
    end, start = Pose((0.1 - inside, 0.2, 0.08)), Pose((0.05, -0.2, 0.04))
    task = Task("verge", (Object("red", Box((0.05, 0.05, 0.08)), start, At(end)), block))
    home = two_boxes()[1].home
    actions = carry(Hand(home), "red", start, shifted(end, np.array([0.0, 0.0, 0.1])), 0.05, ("table", "block"))
    lower, release, retreat = actions[-1].steps
    lay = replace(actions[-1], name="lay-on", steps=(lower, release, Fall("red", end), retreat))
    starts = {"red": start, "block": block.pose}
    plan = Plan("verge", "panda", 0, starts, home, {"red": end}, (*actions[:-1], lay))
    said = [problem.sentence for problem in check(task, plan).problems]
    assert any("rolls or tips on" in sentence for sentence in said) != stays, said


@pytest.mark.parametrize(("far", "thick", "tips"), [(0.15, 0.012, True), (0.15, 0.04, False), (0.02, 0.012, False)])
@pytest.mark.parametrize("places", [(0.05,), (-0.01, 0.11)])
def test_what_is_fallen_upon_tips_over_where_it_is_narrow(far, thick, tips, places):
    """On one body, or on two that carry together what falls: one of them is met first."""
    dominoes = [Object(f"domino{x}", Box((thick, 0.06, 0.1)), Pose((x, 0.2, 0.05))) for x in places]
    start, end = Pose((0.05, -0.2, 0.02)), Pose((0.05, 0.2, 0.12))
    length = 0.05 if len(places) == 1 else 0.16
    task = Task("domino", (Object("red", Box((length, 0.05, 0.04)), start, At(end), mass=1.0), *dominoes))
    home = two_boxes()[1].home
    actions = carry(
        Hand(home), "red", start, shifted(end, np.array([0.0, 0.0, far])), 0.05, ("table", dominoes[0].name)
    )
    lower, release, retreat = actions[-1].steps
    lay = replace(actions[-1], name="lay-on", steps=(lower, release, Fall("red", end), retreat))
    starts = {"red": start, **{domino.name: domino.pose for domino in dominoes}}
    plan = Plan("domino", "panda", 0, starts, home, {"red": end}, (*actions[:-1], lay))
    said = [problem.sentence for problem in check(task, plan).problems]
    for domino in dominoes:
        assert any(f"{domino.name} tips over when red falls" in sentence for sentence in said) == tips, said


def test_the_centre_of_mass_is_the_task_s():
    size, start = Box((0.2, 0.04, 0.04)), Pose((0.05, -0.2, 0.02))
    block = Object("block", Box((0.05, 0.05, 0.06)), Pose((0.05, 0.2, 0.03)))
    end = Pose((0.05, 0.2, 0.08))

    def verdict(center: float) -> set[str]:
        inertia = Inertia(Pose((center, 0.0, 0.0)), (1e-4, 1e-4, 1e-4))
        bar = Object("red", size, start, At(end), inertia=inertia)
        home = two_boxes()[1].home
        actions = carry(Hand(home), "red", start, end, 0.04, ("table", "block"))
        starts = {"red": start, "block": block.pose}
        plan = Plan("bar", "panda", 0, starts, home, {"red": end}, tuple(actions))
        return kinds(Task("bar", (bar, block)), plan)

    assert not verdict(0.0)
    assert "support" in verdict(0.06)


def test_light_weights_do_not_tip_a_plank_one_after_the_other():
    """Each shifts the common centre of mass by less than the tolerance; all of them take it beyond the block."""
    block = Object("block", Box((0.05, 0.06, 0.06)), Pose((0.05, 0.0, 0.03)))
    plank = Object("plank", Box((0.26, 0.06, 0.02)), Pose((0.05, 0.0, 0.07)), mass=0.05)
    ballast = Object("ballast", Box((0.04, 0.06, 0.02)), Pose((0.074, 0.0, 0.09)), mass=3.0)
    size = Box((0.03, 0.03, 0.06))
    places = [Pose((x, y, 0.11)) for x in (0.125, 0.16) for y in (-0.015, 0.016)]
    weights = [
        Object(f"w{i}", size, Pose((-0.15 + 0.1 * i, -0.25, 0.03)), At(place), mass=0.03)
        for i, place in enumerate(places)
    ]
    task = Task("grains", (block, plank, ballast, *weights))
    hand, home = Hand(two_boxes()[1].home), two_boxes()[1].home
    goals = {thing.name: thing.goal.pose for thing in weights}
    starts = {thing.name: thing.pose for thing in task.objects}

    def said(count: int) -> list[str]:
        hand.q = home
        actions = [
            a for w in weights[:count] for a in carry(hand, w.name, w.pose, w.goal.pose, 0.03, ("table", "plank"))
        ]
        plan = Plan("grains", "panda", 0, starts, home, goals, tuple(actions))
        return [p.sentence for p in check(task, plan).problems if p.kind == "support"]

    assert not said(1)
    assert any("tips over with what it stands among" in sentence for sentence in said(4))


def test_what_carries_a_goal_is_not_taken_away():
    """The goal is on a block that no goal is set for: it does not settle to the table because the block is gone."""
    size, start, block = Box((0.04, 0.04, 0.06)), Pose((0.05, -0.25, 0.03)), Box((0.05, 0.05, 0.06))
    goal, low, below, aside = (
        Pose(at) for at in ((0.05, 0.1, 0.09), (0.05, 0.1, 0.03), (0.05, 0.1, 0.03), (0.05, 0.28, 0.03))
    )
    task = Task("stand", (Object("red", size, start, At(goal)), Object("block", block, below)))
    home = two_boxes()[1].home
    hand = Hand(home)
    actions = [
        *carry(hand, "block", below, aside, 0.05, ("table", "table")),
        *carry(hand, "red", start, low, 0.04, ("table", "table")),
    ]
    plan = Plan("stand", "panda", 0, {"red": start, "block": below}, home, {"red": low}, tuple(actions))
    assert "goal" in kinds(task, plan)
    up = carry(Hand(home), "red", start, goal, 0.04, ("table", "block"))
    assert not kinds(task, replace(plan, goals={"red": goal}, actions=tuple(up)))


def on_top(under, at: Pose, shape, end: Pose) -> tuple[Task, Plan]:
    """Something is said to stand on something, from the start."""
    task = Task("top", (Object("under", under, at), Object("red", shape, end)))
    return task, Plan("top", "panda", 0, {"under": at, "red": end}, two_boxes()[1].home, {}, ())


@pytest.mark.parametrize(
    ("under", "at", "shape", "end", "stays"),
    [
        (Sphere(0.03), Pose((0.1, 0.0, 0.03)), Sphere(0.03), Pose((0.1, 0.0, 0.09)), False),
        (Capsule(0.03, 0.06), Pose((0.1, 0.0, 0.06)), Box((0.05, 0.05, 0.1)), Pose((0.1, 0.0, 0.17)), False),
        (Box((0.05, 0.05, 0.06)), Pose((0.1, 0.0, 0.03)), Capsule(0.02, 0.06), Pose((0.1, 0.0, 0.11)), False),
        (Box((0.06, 0.06, 0.06)), Pose((0.1, 0.0, 0.03)), Sphere(0.03), Pose((0.1, 0.0, 0.09)), True),
        (Box((0.06, 0.06, 0.02)), Pose((0.1, 0.0, 0.01)), Box((0.005, 0.05, 0.1)), Pose((0.1, 0.0, 0.07)), True),
    ],
)
def test_nothing_starts_on_a_round_top_or_on_its_own_tip(under, at, shape, end, stays):
    assert ("start" not in kinds(*on_top(under, at, shape, end))) == stays


@pytest.mark.parametrize(
    ("within", "loaded", "falls"),
    [(-9e-4, False, True), (0.0, False, True), (5e-4, False, False), (-5e-4, True, False)],
)
@pytest.mark.parametrize("size", [(0.012, 0.05, 0.1), (0.06, 0.05, 0.02)])
def test_what_starts_on_the_very_edge_of_what_carries_it_falls(size, within, loaded, falls):
    """Up to a millimetre beyond it counted as noise: it fell, 93 to 124 mm off in two simulators."""
    block, x = Object("block", Box((0.1, 0.1, 0.05)), Pose((0.1, 0.0, 0.025)), mass=2.0), 0.15 - within
    thing = Object("thing", Box(size), Pose((x, 0.0, 0.05 + size[2] / 2)), mass=0.1)
    load = Object("load", Box((0.01, 0.05, 0.02)), Pose((x - size[0] / 2 + 0.005, 0.0, 0.06 + size[2])), mass=0.1)
    things = (block, thing, load) if loaded else (block, thing)
    plan = Plan("edge", "panda", 0, {o.name: o.pose for o in things}, two_boxes()[1].home, {}, ())
    found = [problem.sentence for problem in check(Task("edge", things), plan).problems]
    assert any("thing starts on the very edge" in sentence for sentence in found) == falls, found
    assert bool(found) == falls, found


@pytest.mark.parametrize(
    ("deep", "hemmed", "falls"),
    [(1.5e-3, False, True), (5e-4, False, True), (-1e-4, False, False), (5e-4, True, False)],
)
def test_what_is_round_does_not_start_pressed_by_what_it_rolls_away_from(deep, hemmed, falls):
    """It is squeezed out before anything is done: by 5.8 and 0.7 mm in PyBullet, by 106 and 17 in MuJoCo."""
    block = Object("block", Box((0.06, 0.06, 0.06)), Pose((0.0, 0.0, 0.03)), mass=0.5)
    ball = Object("ball", Sphere(0.015), Pose((0.045 - deep, 0.0, 0.015)), mass=0.02)
    wall = Object("wall", block.shape, Pose((0.09 - deep, 0.0, 0.03)), mass=0.5)
    things = (block, ball, wall) if hemmed else (block, ball)
    plan = Plan("pressed", "panda", 0, {o.name: o.pose for o in things}, two_boxes()[1].home, {}, ())
    found = [problem.sentence for problem in check(Task("pressed", things), plan).problems]
    assert any("pressed" in sentence for sentence in found) == falls, found
    assert bool(found) == falls, found
