"""Plans that a hostile hand would write; docs/trust/attacks.md has the whole log."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking import check
from tamp.checking.physics.stacks import off_balance, stack_of
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.errors import PlanError, TaskError
from tamp.task import At, Box, Capsule, Fall, Grip, Inertia, Move, Object, Plan, Pose, Release, Sphere, Task, Trajectory
from tests.checking.handmade import RISE, Hand, carry, two_boxes
from tests.checking.mutations.editing import put, shifted, step_at, steps_of
from tests.checking.mutations.motions import object_in_the_way, shift_into_table


def kinds(task: Task, plan: Plan) -> set[str]:
    return {problem.kind for problem in check(task, plan).problems}


@pytest.fixture(scope="module")
def valid() -> tuple[Task, Plan]:
    return two_boxes()


def written(task: Task, **poses: Pose) -> Task:
    """The task with objects written elsewhere."""
    return replace(task, objects=tuple(replace(o, pose=poses.get(o.name, o.pose)) for o in task.objects))


def test_goals_given_as_the_start_solve_nothing(valid):
    task, plan = valid
    assert "start" in kinds(task, replace(plan, start={**plan.start, **plan.goals}, actions=()))


def test_an_object_in_the_air_frees_no_other(valid):
    task, plan = valid
    loose = written(task, can=shifted(task.object("can").pose, np.array([0.0, 0.0, 0.1])))
    assert check(loose, plan).accepted
    cheat = replace(plan, start={**plan.start, **plan.goals}, actions=())
    assert "start" in kinds(loose, cheat)


def test_an_object_in_the_air_comes_straight_down(valid):
    task, plan = valid
    loose = written(task, can=shifted(task.object("can").pose, np.array([0.05, 0.0, 0.05])))
    assert "start" in kinds(loose, plan)


def test_swapped_names_start_nothing(valid):
    task, plan = valid
    assert "start" in kinds(
        task, replace(plan, start={**plan.start, "red": plan.start["can"], "can": plan.start["red"]})
    )


@pytest.mark.parametrize("far", [0.02, 0.3])
def test_a_goal_of_its_own_is_not_the_task_s(valid, far):
    task, plan = valid
    goals = {**plan.goals, "green": shifted(plan.goals["green"], np.array([far, 0.0, 0.0]))}
    assert "goal" in kinds(task, replace(plan, goals=goals))


def test_goals_and_ends_within_tolerance_each_do_not_add_up(valid):
    task, plan = valid
    objects = tuple(
        replace(o, goal=At(shifted(o.goal.pose, np.array([0.019, 0.0, 0.0])))) if o.name == "red" else o
        for o in task.objects
    )
    goals = {**plan.goals, "red": shifted(plan.goals["red"], np.array([0.0045, 0.0, 0.0]))}
    assert "goal" in kinds(replace(task, objects=objects), replace(plan, goals=goals))


@pytest.mark.parametrize("opening", [0.2, -0.01, float("nan")])
def test_fingers_open_no_wider_than_they_can(valid, opening):
    task, plan = valid
    where = steps_of(plan, Move)[0]
    assert "limits" in kinds(task, put(plan, where, replace(step_at(plan, where), opening=opening)))
    where = steps_of(plan, Release)[0]
    assert kinds(task, put(plan, where, replace(step_at(plan, where), opening=opening))) & {"limits", "release"}
    where = steps_of(plan, Grip)[0]
    assert "grasp" in kinds(task, put(plan, where, replace(step_at(plan, where), width=opening)))


@pytest.mark.parametrize("mutation", [object_in_the_way, shift_into_table])
def test_contacts_that_allow_everything_allow_nothing(valid, mutation):
    task, plan = mutation(*valid, np.random.default_rng(0))
    names = ["robot", "table", *(o.name for o in task.objects)]
    every = frozenset((a, b) for a in names for b in names)
    for where in steps_of(plan, Move):
        plan = put(plan, where, replace(step_at(plan, where), contacts=every))
    assert "collision" in kinds(task, plan)


def test_a_plan_for_another_task_is_refused(valid):
    task, plan = valid
    with pytest.raises(PlanError, match="for task"):
        check(replace(task, name="other"), plan)


def renamed(task: Task, plan: Plan, old: str, new: str) -> tuple[Task, Plan]:
    def change(name: str) -> str:
        return new if name == old else name

    def step(s):
        if isinstance(s, Grip):
            return replace(s, attachment=replace(s.attachment, object=change(s.attachment.object)))
        if isinstance(s, Release):
            return replace(s, object=change(s.object))
        held = None if s.held is None else replace(s.held, object=change(s.held.object))
        return replace(s, held=held, contacts=frozenset((change(a), change(b)) for a, b in s.contacts))

    objects = tuple(replace(o, name=change(o.name)) for o in task.objects)
    actions = tuple(
        replace(a, arguments=tuple(map(change, a.arguments)), steps=tuple(map(step, a.steps))) for a in plan.actions
    )
    start, goals = ({change(n): p for n, p in poses.items()} for poses in (plan.start, plan.goals))
    return replace(task, objects=objects), replace(plan, start=start, goals=goals, actions=actions)


@pytest.mark.parametrize("name", ["panda_link0", "panda_link5", "panda_hand", "panda_leftfinger"])
def test_an_object_called_like_a_link_is_an_object(valid, name):
    assert check(*renamed(*valid, "red", name)).accepted
    task, plan = object_in_the_way(*valid, np.random.default_rng(0))
    assert "collision" in kinds(*renamed(task, plan, "can", name))
    assert "collision" in kinds(*renamed(task, plan, "red", name))


@pytest.mark.parametrize("name", ["table", "robot", "can"])
def test_names_that_are_taken_are_refused(valid, name):
    with pytest.raises(TaskError, match="reserved or taken"):
        check(*renamed(*valid, "red", name))


def test_a_dip_into_the_table_between_two_samples_is_seen(valid):
    task, plan = valid
    home = np.array(plan.home)
    positions, velocities = np.tile(home, (4, 1)), np.zeros((4, 7))
    velocities[1, 1] = 0.5
    dip = Trajectory(np.array([0.0, 2.0, 22.0, 23.0]), positions, velocities)
    where = steps_of(plan, Move)[0]
    move = step_at(plan, where)
    assert "collision" in kinds(task, put(plan, where, replace(move, trajectory=dip), move))


def test_a_release_shifts_nothing_aside(valid):
    task, plan = valid
    where = steps_of(plan, Release)[-1]
    release = step_at(plan, where)
    beside = put(plan, where, replace(release, pose=shifted(release.pose, np.array([0.012, 0.0, 0.0]))))
    assert "release" in kinds(task, beside)


def test_small_shifts_do_not_add_up():
    goal = Pose((0.05, 0.2, 0.04))
    task = Task("creep", (Object("red", Box((0.05, 0.05, 0.08)), Pose((0.05, -0.2, 0.04)), At(goal)),))
    hand, at, actions = Hand(two_boxes()[1].home), task.objects[0].pose, []
    for y in (0.0, 0.1, 0.0, 0.2):
        end = Pose((0.05, y, 0.04))
        two = carry(hand, "red", at, end, 0.05, ("table", "table"))
        creep = shifted(end, np.array([0.0018, 0.0, 0.0]))
        lowered, release, left = two[3].steps
        two[3] = replace(two[3], steps=(lowered, replace(release, pose=creep), left))
        actions, at = actions + two, creep
    plan = Plan("creep", "panda", 0, {"red": task.objects[0].pose}, two_boxes()[1].home, {"red": at}, tuple(actions))
    said = [problem.sentence for problem in check(task, plan).problems]
    assert any("add up" in sentence for sentence in said)


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


def test_an_action_without_a_rule_is_refused_by_name(valid):
    task, plan = valid
    named = replace(plan.actions[0], name="teleport")
    problem = check(task, replace(plan, actions=(named,))).problems[0]
    assert "no rule for action 'teleport'" in problem.sentence
    assert "pick, place" in problem.sentence


def test_a_regrasp_of_the_wrong_object_is_seen(valid):
    task, plan = valid
    where = steps_of(plan, Grip)[1]
    grip = step_at(plan, where)
    wrong = put(plan, where, replace(grip, attachment=replace(grip.attachment, object="red")))
    assert {"precondition", "grasp", "continuity"} & kinds(task, wrong)


def alone(shape, start: Pose, end: Pose, width: float, lift: float = 0.0, **about) -> tuple[Task, Plan]:
    """One object carried across the table, gripped `lift` above its origin."""
    task = Task("alone", (Object("red", shape, start, At(end), **about),))
    home = two_boxes()[1].home
    actions = carry(Hand(home), "red", start, end, width, ("table", "table"), grip_height=lift)
    return task, Plan("alone", "panda", 0, {"red": start}, home, {"red": end}, tuple(actions))


def unmoved(at: dict[str, tuple[object, Pose, Pose]]) -> tuple[Task, Plan]:
    """Nothing is done: each object, by its shape, start and goal, is said to start at its goal."""
    task = Task("unmoved", tuple(Object(name, shape, start, At(goal)) for name, (shape, start, goal) in at.items()))
    goals = {name: goal for name, (_, _, goal) in at.items()}
    return task, Plan("unmoved", "panda", 0, goals, two_boxes()[1].home, goals, ())


def test_a_narrow_thing_that_stands_does_not_walk():
    stick = Box((0.02, 0.02, 0.2))
    for turn in ((0.0, 0.0, np.pi), (np.pi, 0.0, 0.0)):
        end = Pose.from_rpy((0.3, 0.0, 0.1), turn)
        assert "start" in kinds(*unmoved({"stick": (stick, Pose((0.1, 0.0, 0.1)), end)}))


@pytest.mark.parametrize("above", [0.0, 0.05])
def test_neighbours_do_not_jostle_each_other_from_rest(above):
    box = Box((0.05, 0.05, 0.05))
    first, second = Pose((0.1, 0.0, 0.025)), Pose((0.151 - above, 0.0, 0.025 + above))
    by = np.array([0.02, 0.0, 0.0])
    pair = {"a": (box, first, shifted(first, by)), "b": (box, second, shifted(second, by))}
    assert "start" in kinds(*unmoved(pair))


def test_nothing_stands_in_the_table():
    task, plan = alone(Box((0.05, 0.05, 0.08)), Pose((0.05, -0.2, 0.04)), Pose((0.05, 0.2, 0.0365)), 0.05)
    assert "support" in kinds(task, plan)


def test_fingers_slip_off_a_ball_that_they_hold_by_its_top():
    radius, lift = 0.03, 0.024
    width = 2 * np.sqrt(radius**2 - (lift - 0.008) ** 2)
    start, end = Pose((0.05, -0.2, radius)), Pose((0.05, 0.2, radius))
    assert check(*alone(Sphere(radius), start, end, 2 * radius)).accepted
    said = check(*alone(Sphere(radius), start, end, width, lift)).problems
    assert any("slips out of the fingers" in problem.sentence for problem in said)


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


def test_what_is_carried_grazes_nothing_on_its_way():
    """A motion that calls itself a lift, and says that everything may touch, touches only what it leaves."""
    task, plan = alone(Box((0.05, 0.05, 0.08)), Pose((0.05, -0.2, 0.04)), Pose((0.05, 0.2, 0.04)), 0.05)
    height = RISE + 0.0025
    pillar = Object("pillar", Box((0.03, 0.03, height)), Pose((0.05, 0.12, height / 2)))
    task = replace(task, objects=(*task.objects, pillar))
    plan = replace(plan, start={**plan.start, "pillar": pillar.pose})
    every = frozenset((a, b) for a in ("robot", "table", "red", "pillar") for b in ("robot", "table", "red", "pillar"))
    across = step_at(plan, where := steps_of(plan, Move, "transfer")[0])
    plan = put(plan, where, replace(across, phase="lift", contacts=every))
    said = check(task, plan).problems
    assert any(problem.kind == "collision" and {"red", "pillar"} == {*problem.bodies} for problem in said), said


def test_a_home_that_is_not_a_number_is_refused(valid):
    task, plan = valid
    assert "start" in kinds(task, replace(plan, home=(float("nan"),) * 7))


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


def test_goals_that_the_task_does_not_set_are_refused(valid):
    task, plan = valid
    assert "goal" in kinds(task, replace(plan, goals={**plan.goals, "ghost": Pose((0.0, 0.0, 0.0))}))
    assert "goal" in kinds(task, replace(plan, goals={**plan.goals, "can": plan.start["can"]}))


def test_a_quaternion_and_its_opposite_are_one_orientation(valid):
    task, plan = valid
    where = steps_of(plan, Grip)[0]
    grip = step_at(plan, where)
    place = grip.attachment.T_tool_object
    opposite = Pose(place.xyz, tuple(-value for value in place.quat))
    assert check(
        task, put(plan, where, replace(grip, attachment=replace(grip.attachment, T_tool_object=opposite)))
    ).accepted


@pytest.mark.parametrize(
    ("size", "start", "turn"),
    [
        ((0.02, 0.02, 0.02), (0.0, 0.0, 0.0), (0.0, 0.0, 0.2)),  # a small cube is turned where it stands
        ((0.02, 0.02, 0.2), (0.0, 0.0, 0.0), (0.0, np.pi / 2, 0.0)),  # a stick that stands lies down
        ((0.02, 0.15, 0.25), (0.0, 0.0, 0.0), (0.0, np.pi / 2, 0.0)),  # a book does
    ],
)
def test_what_stands_firmly_neither_turns_nor_lies_down(size, start, turn):
    end = Pose.from_rpy((0.1, 0.0, (size[0] if turn[1] else size[2]) / 2), turn)
    at = Pose.from_rpy((0.1, 0.0, size[2] / 2), start)
    assert "start" in kinds(*unmoved({"thing": (Box(size), at, end)}))
    assert not kinds(*unmoved({"thing": (Box(size), at, at)}))
    above = shifted(at, np.array([0.0, 0.0, 0.0015]))
    assert "start" in kinds(*unmoved({"thing": (Box(size), above, end)}))
    assert not kinds(*unmoved({"thing": (Box(size), above, at)}))


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


def test_a_hand_that_draws_back_squeezes_nothing(valid):
    task, plan = valid
    where = steps_of(plan, Move, "retreat")[0]
    retreat = step_at(plan, where)
    pressed = put(plan, where, replace(retreat, opening=0.0485))
    assert any("squeezes red" in problem.sentence for problem in check(task, pressed).problems)


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


@pytest.mark.parametrize("far", [1e6, 1e160, -1e300])
def test_places_beyond_all_bounds_are_refused(valid, far):
    task, plan = valid
    away = Pose((0.1, far, 0.05))
    assert "start" in kinds(task, replace(plan, start={**plan.start, "can": away}))
    where = steps_of(plan, Release)[0]
    assert "release" in kinds(task, put(plan, where, replace(step_at(plan, where), pose=away)))


@pytest.mark.parametrize(("height", "dragged"), [(-0.0005, True), (0.0005, False)])
def test_what_is_held_is_not_dragged_over_what_it_stands_on(height, dragged):
    """Pressed onto a block by half a millimetre, it slides 6 cm aside before it is lifted."""
    slab = Object("slab", Box((0.2, 0.2, 0.04)), Pose((0.05, 0.0, 0.02)))
    start, end = Pose((0.05, -0.04, 0.08)), Pose((0.05, 0.25, 0.04))
    task = Task("drag", (Object("red", Box((0.05, 0.05, 0.08)), start, At(end)), slab))
    home = two_boxes()[1].home
    hand = Hand(home)
    first, pick, *_ = carry(hand, "red", start, end, 0.05, ("slab", "table"))
    reach, grip, lift = pick.steps
    hand = Hand(tuple(reach.trajectory.positions[-1]))
    tool = start @ grip.attachment.T_tool_object.inverse()
    slid = shifted(tool, np.array([0.0, 0.06, height]))
    path = [replace(lift, trajectory=hand.line(at)) for at in (slid, shifted(slid, np.array([0.0, 0.0, RISE])))]
    after = carry(hand, "red", start, end, 0.05, ("slab", "table"))[-2:]
    hand.q = tuple(path[-1].trajectory.positions[-1])
    lowered, release, left = after[1].steps
    above_end = shifted(end, np.array([0.0, 0.0, RISE])) @ grip.attachment.T_tool_object.inverse()
    across = replace(after[0], steps=(replace(after[0].steps[0], trajectory=hand.free(above_end)),))
    lower = replace(lowered, trajectory=hand.line(shifted(above_end, np.array([0.0, 0.0, -RISE]))))
    retreat = replace(left, trajectory=hand.line(above_end))
    place = replace(after[1], steps=(lower, release, retreat))
    actions = (first, replace(pick, steps=(reach, grip, *path)), across, place)
    plan = Plan("drag", "panda", 0, {"red": start, "slab": slab.pose}, home, {"red": end}, actions)
    said = [problem.sentence for problem in check(task, plan).problems]
    assert said == [] if not dragged else any("is dragged over slab" in sentence for sentence in said), said
