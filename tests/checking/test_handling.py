"""What a hand does on its way to an object, with it, and away from it, that nothing would bear."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tamp.checking import check
from tamp.checking.actions.grip_and_release import check_unsqueezed
from tamp.checking.geometry.pad_region import between_pads
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import (
    Action,
    At,
    Attachment,
    Box,
    Cylinder,
    Grip,
    Mesh,
    Move,
    Object,
    Plan,
    Pose,
    Release,
    Sphere,
    Task,
    Trajectory,
    load_robot,
)
from tamp.task.mesh.parts import Part, convex_hull, parts
from tests.checking.handmade import DOWN, OPEN, Hand, above, carry, two_boxes
from tests.checking.handmade import tree as handmade_tree
from tests.checking.mutations.editing import shifted

BOX, START, GOAL = Box((0.05, 0.05, 0.08)), Pose((0.05, -0.2, 0.04)), Pose((0.05, 0.2, 0.04))
HOME = load_robot("panda").home
TOUCHING = frozenset({("robot", "red"), ("red", "table")})


def judged(objects: list[Object], actions: list[Action]) -> str:
    goals = {o.name: o.goal.pose for o in objects if isinstance(o.goal, At)}
    starts = {o.name: o.pose for o in objects}
    plan = Plan("handling", "panda", 0, starts, HOME, goals, tuple(actions))
    return " ".join(problem.sentence for problem in check(Task("handling", tuple(objects)), plan).problems)


@pytest.mark.parametrize(("opening", "wrong"), [(0.049, True), (0.0505, True), (0.054, False)])
def test_what_is_as_wide_as_the_fingers_are_open_is_not_let_go(opening, wrong):
    actions = carry(Hand(HOME), "red", START, GOAL, 0.0465, ("table", "table"))
    lower, release, retreat = actions[-1].steps
    steps = (lower, replace(release, opening=opening), replace(retreat, opening=opening))
    found = judged([Object("red", BOX, START, At(GOAL))], [*actions[:-1], replace(actions[-1], steps=steps)])
    assert ("red between them is 50.0 mm wide" in found) == wrong


@pytest.mark.parametrize(("force", "wrong"), [(None, False), (40.0, False), (70.0, False), (71.0, True), (0.0, True)])
def test_fingers_press_with_no_more_force_than_they_have(force, wrong):
    before, pick, *after = carry(Hand(HOME), "red", START, GOAL, 0.05, ("table", "table"))
    steps = [replace(step, force=force) if isinstance(step, Grip) else step for step in pick.steps]
    actions = [before, replace(pick, steps=tuple(steps)), *after]
    found = judged([Object("red", BOX, START, At(GOAL))], actions)
    assert ("the fingers cannot press with" in found) == wrong
    assert bool(found) == wrong


@pytest.mark.parametrize(("sunk", "wrong"), [(0.0, False), (0.0035, True)])
def test_what_is_held_is_not_pressed_into_what_it_is_dragged_over(sunk, wrong):
    T_object_tool, hand = Pose((0.0, 0.0, 0.005), DOWN), Hand(HOME)
    held, down = Attachment("red", T_object_tool.inverse()), np.array([0.0, 0.0, -sunk])
    go = Move("transit", hand.free(above(START @ T_object_tool)), OPEN)
    reach = Move("approach", hand.line(START @ T_object_tool), OPEN)
    over = [
        Move(phase, hand.line(at @ T_object_tool), 0.05, held, TOUCHING)
        for phase, at in (("lift", shifted(START, down)), ("lift", shifted(GOAL, down)), ("lower", GOAL))
    ]
    leave = Move("retreat", hand.line(above(GOAL @ T_object_tool)), OPEN)
    pick = Action("pick", ("red",), (reach, Grip(held, 0.05), *over[:2]))
    place = Action("place", ("red",), (over[2], Release("red", GOAL, OPEN), leave))
    found = judged([Object("red", BOX, START, At(GOAL))], [Action("move", (), (go,)), pick, place])
    assert ("red and table interpenetrate" in found) == wrong


def test_the_palm_does_not_enter_what_the_fingers_close_on():
    deep = carry(Hand(HOME), "red", START, GOAL, 0.05, ("table", "table"), grip_height=0.0)
    assert "panda_hand and red interpenetrate" in judged([Object("red", BOX, START, At(GOAL))], deep)


@pytest.mark.parametrize(("gap", "wrong"), [(0.0, False), (0.0029, True)])
def test_gaps_in_a_stack_add_up(gap, wrong):
    """Each box seems to stand on the next; the topmost is a centimetre too high."""
    slab, level = Box((0.06, 0.05, 0.02)), 0.02 + gap
    stack = [Object(f"slab{i}", slab, Pose((0.05, -0.2, 0.01 + gap + i * level))) for i in range(5)]
    goal = Pose((0.05, 0.2, 0.01))
    stack[-1] = replace(stack[-1], goal=At(goal))
    actions = carry(Hand(HOME), "slab4", stack[-1].pose, goal, 0.05, ("slab3", "table"))
    assert ("slab4 starts 14.5 mm above where it stands" in judged(stack, actions)) == wrong


def stacked(count: int, gap: float) -> str:
    """What is said of slabs that are stacked, each so far above the one below [m]."""
    hand, things, actions = Hand(HOME), [], []
    for i in range(count):
        start, goal = Pose((0.1 * i, -0.3, 0.01)), Pose((0.1, 0.2, 0.01 + gap + i * (0.02 + gap)))
        things.append(Object(f"slab{i}", Box((0.06, 0.05, 0.02)), start, At(goal)))
        actions += carry(hand, f"slab{i}", start, goal, 0.05, ("table", f"slab{i - 1}" if i else "table"))
    return judged(things, actions)


def test_gaps_of_what_is_stacked_add_up():
    found = stacked(3, 0.0029)
    assert "slab2 stands 8.7 mm above" in found and "slab1 stands" not in found


def test_depths_of_what_is_stacked_add_up():
    found = stacked(3, -0.0014)
    assert "slab2 stands 4.2 mm below" in found and "slab1 stands" not in found


LYING = (0.7071067811865476, 0.0, 0.0, 0.7071067811865476)


@pytest.mark.parametrize(
    ("shape", "pose", "wrong"),
    [
        (Sphere(0.03), Pose((0.05, 0.2, 0.03)), True),
        (Cylinder(0.03, 0.12), Pose((0.05, 0.2, 0.03), LYING), True),
        (Cylinder(0.03, 0.06), Pose((0.05, 0.2, 0.03)), False),
        (Box((0.014, 0.06, 0.06)), Pose((0.05, 0.2, 0.03)), False),
    ],
)
def test_nothing_stays_on_what_rolls(shape, pose, wrong):
    goal = Pose((0.05, 0.2, 0.06 + START.xyz[2]))
    actions = carry(Hand(HOME), "red", START, goal, 0.05, ("table", "under"))
    found = judged([Object("red", BOX, START, At(goal)), Object("under", shape, pose)], actions)
    assert ("red does not stay on under, which rolls on table" in found) == wrong, found


def test_neighbours_are_not_in_each_other():
    row = [Object(f"box{k}", BOX, Pose((0.05 + 0.0465 * k, 0.3, 0.04))) for k in range(2)]
    actions = carry(Hand(HOME), "red", START, GOAL, 0.05, ("table", "table"))
    assert "box0 stands 3.5 mm inside box1" in judged([Object("red", BOX, START, At(GOAL)), *row], actions)


def in_two(part: Part, path: Path) -> Mesh:
    """A convex body cut in two at x = 0, as a mesh of two groups."""
    lines, count = [], 1
    for side in (-1.0, 1.0):
        points = part.vertices.copy()
        points[:, 0] = side * np.maximum(side * points[:, 0], 0.0)
        half = convex_hull(points)
        lines += [f"g half{count}", *(f"v {x} {y} {z}" for x, y, z in half.vertices)]
        lines += [f"f {a} {b} {c}" for a, b, c in half.faces + count]
        count += len(half.vertices)
    path.write_text("\n".join(lines))
    return Mesh(path)


def test_bodies_of_several_pieces_are_not_in_each_other(tmp_path):
    halves = in_two(parts(BOX)[0], tmp_path / "box.obj")
    row = [Object(f"box{k}", halves, Pose((0.05 + 0.0465 * k, 0.3, 0.04))) for k in range(2)]
    actions = carry(Hand(HOME), "red", START, GOAL, 0.05, ("table", "table"))
    assert "box0 stands 3.5 mm inside box1" in judged([Object("red", BOX, START, At(GOAL)), *row], actions)


def test_nothing_stays_on_a_ball_of_two_halves(tmp_path):
    ball = in_two(parts(Sphere(0.03))[0], tmp_path / "ball.obj")
    goal = Pose((0.05, 0.2, 0.06 + START.xyz[2]))
    actions = carry(Hand(HOME), "red", START, goal, 0.05, ("table", "under"))
    found = judged([Object("red", BOX, START, At(goal)), Object("under", ball, Pose((0.05, 0.2, 0.03)))], actions)
    assert "red does not stay on under" in found


def test_jumps_where_motions_meet_add_up():
    steps, q = [], np.array(HOME)
    for _ in range(20):
        q = q + np.array([9e-5, *[0.0] * 6])
        steps.append(Move("transit", Trajectory(np.array([0.0, 0.01]), np.array([q, q]), np.zeros((2, 7))), OPEN))
    assert "0.0002 rad with the jumps before" in judged([Object("red", BOX, START)], [Action("move", (), tuple(steps))])


def aside(actions: list[Action], start: Pose, goal: Pose, by: Pose) -> list[Action]:
    """The same actions with an object, at rest at `start` and `goal`, that lies so far aside in the hand."""

    def moved(step):
        if isinstance(step, Move) and step.held is not None:
            return replace(step, held=replace(step.held, T_tool_object=step.held.T_tool_object @ by))
        if isinstance(step, Grip):
            attachment = step.attachment
            return replace(step, attachment=replace(attachment, T_tool_object=attachment.T_tool_object @ by))
        return replace(step, pose=goal) if isinstance(step, Release) else step

    return [replace(action, steps=tuple(map(moved, action.steps))) for action in actions]


@pytest.mark.parametrize(("by", "mass", "wrong"), [(0.0, 3.0, False), (0.1, 0.1, False), (0.1, 1.0, True)])
def test_what_is_held_far_from_its_middle_swings_down(by, mass, wrong):
    start, goal = Pose((0.0, -0.2, 0.02)), Pose((0.0, 0.2, 0.02))
    grips = carry(Hand(HOME), "red", Pose((by, -0.2, 0.02)), Pose((by, 0.2, 0.02)), 0.04, ("table", "table"))
    bar = Object("red", Box((0.3, 0.04, 0.04)), start, At(goal), mass=mass)
    found = judged([bar], aside(grips, start, goal, Pose((-by, 0.0, 0.0))))
    assert ("red swings down in the fingers" in found) == wrong, found


@pytest.mark.parametrize(("width", "wrong"), [(0.03, True), (0.028, False)])
def test_the_fingers_close_on_one_object_alone(width, wrong):
    """Two boxes side by side are both between the pads; where the other one is narrower they do not touch it."""
    start, goal = Pose((0.0601, -0.2, 0.025)), Pose((0.0601, 0.2, 0.025))
    grips = carry(Hand(HOME), "red", Pose((0.05, -0.2, 0.025)), Pose((0.05, 0.2, 0.025)), 0.03, ("table", "table"))
    twins = [
        Object("red", Box((0.02, 0.03, 0.05)), start, At(goal)),
        Object("other", Box((0.02, width, 0.05)), Pose((0.0399, -0.2, 0.025))),
    ]
    found = judged(twins, aside(grips, start, goal, Pose((0.0101, 0.0, 0.0))))
    assert ("the fingers that grip red close on other too" in found) == wrong, found


def test_the_fingers_leave_what_an_object_stands_on():
    """Pads that reach below the lower face of a thin slab close on the slab below as well."""
    slab, low, high = Box((0.06, 0.05, 0.02)), Pose((0.05, -0.2, 0.01)), Pose((0.05, -0.2, 0.03))
    goal = Pose((0.05, 0.2, 0.03))
    things = [
        Object("red", slab, high, At(goal)),
        Object("below", slab, low),
        Object("stand", Box((0.04, 0.03, 0.02)), Pose((0.05, 0.2, 0.01))),
    ]
    for lift, wrong in ((0.0, False), (-0.005, True)):
        actions = carry(Hand(HOME), "red", high, goal, 0.05, ("below", "stand"), grip_height=lift)
        assert ("close on below too" in judged(things, actions)) == wrong


@pytest.mark.parametrize(("turned", "wrong"), [(0.0, True), (np.pi / 2, False)])
def test_nothing_stays_on_several_that_all_roll_the_same_way(turned, wrong):
    start, goal, ends = Pose((0.05, -0.2, 0.01)), Pose((0.05, 0.2, 0.05)), (-0.05, 0.04)
    cans = [
        Object(f"can{k}", Cylinder(0.02, 0.08), Pose.from_rpy((0.05 + x, 0.2, 0.02), (np.pi / 2, 0.0, k * turned)))
        for k, x in enumerate(ends)
    ]
    actions = carry(Hand(HOME), "red", start, goal, 0.05, ("table", "can0"))
    found = judged([Object("red", Box((0.16, 0.05, 0.02)), start, At(goal)), *cans], actions)
    assert ("red does not stay on can0 and can1, which all roll the same way" in found) == wrong, found


@pytest.mark.parametrize(
    ("askew", "friction", "halved", "turns"),
    [
        (0.05, 0.5, False, False),
        (0.4, 0.5, False, True),
        (0.4, 1.0, False, False),
        (0.05, 0.5, True, False),
        (0.5, 0.5, True, True),
        (0.4, 1.0, True, False),
    ],
)
def test_pads_that_touch_a_box_by_its_corners_turn_it_where_friction_does_not_hold_it(
    tmp_path, askew, friction, halved, turns
):
    """In PyBullet the second box comes to lie flush between the pads, the others stay as they are."""
    tool = Pose.from_rpy((0.0, 0.0, 0.005), (np.pi, 0.0, askew))
    shape = in_two(parts(BOX)[0], tmp_path / "box.obj") if halved else BOX
    red = Object("red", shape, START, At(GOAL), friction=friction)
    tree = handmade_tree()
    solid = Scene.of(Task("box", (red,))).solids["red"]
    found = between_pads(solid, tool.inverse().matrix, tree.spec.gripper, OPEN, tree.pad_depth(0.05))
    width, held, hand = found[1] - found[0], Attachment("red", tool.inverse()), Hand(HOME)
    go = Move("transit", hand.free(above(START @ tool)), OPEN)
    reach = Move("approach", hand.line(START @ tool), OPEN)
    lift = Move("lift", hand.line(above(START @ tool)), width, held, TOUCHING)
    carried = Move("transfer", hand.free(above(GOAL @ tool)), width, held)
    lower = Move("lower", hand.line(GOAL @ tool), width, held, TOUCHING)
    leave = Move("retreat", hand.line(above(GOAL @ tool)), OPEN)
    pick = Action("pick", ("red",), (reach, Grip(held, width), lift))
    place = Action("place", ("red",), (lower, Release("red", GOAL, OPEN), leave))
    said = judged([red], [Action("move", (), (go,)), pick, Action("move", ("red",), (carried,)), place])
    assert ("lies flush" in said) == turns, said
    assert turns or not said


def squeezed(shape, deep: float, opening: float) -> bool:
    """Whether an empty hand squeezes what reaches so deep between its fingers, from beyond their ends."""
    tree, spec = handmade_tree(), load_robot("panda").gripper
    ends = tree.pad_depth(opening) + spec.pad[2] / 2
    half = parts(shape)[0].vertices[:, 2].max()
    tool = Pose.from_matrix(tree.tool(np.array([HOME]))[0])
    at = tool @ Pose((0.0, 0.0, ends - deep + half))
    scene = Scene.of(Task("squeezed", (Object("thing", shape, at),)))
    found = []
    state = State({"thing": at.matrix}, np.array(HOME))
    check_unsqueezed(scene, state, opening, DEFAULT, lambda kind, *told, **more: found.append(kind))
    return "grasp" in found


def test_closed_fingers_that_touch_something_round_with_their_ends_squeeze_it_not():
    """A nudge presses the ends of closed fingers on a flank by a millimetre or two: what is round slips off there."""
    assert not any(squeezed(Sphere(0.03), deep, 0.0) for deep in (0.00105, 0.0012, 0.0015))
    assert squeezed(Sphere(0.01), 0.01 + 0.004, 0.018)  # pads on both sides of a ball's middle hold it
    assert all(squeezed(Box((0.03, 0.0015, 0.05)), deep, 0.0) for deep in (0.003, 0.01))  # a card between them


@pytest.mark.parametrize(("sunk", "said", "wrong"), [(0.0038, 0.0019, True), (0.0015, 0.0, False)])
def test_what_is_let_go_is_not_pressed_into_what_it_is_put_on(sunk, said, wrong):
    """The hand holds it as deep in the table as a release may be off its place, and that as deep as it may rest."""
    low, end = (Pose((*GOAL.xyz[:2], GOAL.xyz[2] - deep)) for deep in (sunk, said))
    actions = [
        replace(a, steps=tuple(replace(s, pose=end) if isinstance(s, Release) else s for s in a.steps))
        for a in carry(Hand(HOME), "red", START, low, 0.05, ("table", "table"))
    ]
    found = judged([Object("red", BOX, START, At(GOAL))], actions)
    assert ("red is pressed 3.8 mm into table" in found) == wrong, found
    assert wrong or not found


@pytest.mark.parametrize(("by", "wrong"), [(0.9e-6, True), (0.2e-6, False)])
def test_noise_of_the_opening_does_not_add_up_while_something_is_held(by, wrong):
    task, plan = two_boxes()
    creep = 0.0

    def closing(step):
        nonlocal creep
        if isinstance(step, Move) and step.held is not None:
            creep += by
            return replace(step, opening=step.opening - creep)
        return step

    actions = tuple(replace(a, steps=tuple(map(closing, a.steps))) for a in plan.actions[:4])
    said = [problem.sentence for problem in check(task, replace(plan, actions=actions)).problems]
    assert any("while holding" in sentence for sentence in said) is wrong
