"""What gives way, within tolerance, to what is taken from it or put on it: it is met where it has come to."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import trimesh

from tamp.checking import check
from tamp.checking.actions.grip_and_release import check_grip
from tamp.checking.actions.left_standing import check_rest, check_uncovered
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import (
    Action,
    At,
    Attachment,
    Box,
    Fall,
    Grip,
    Mesh,
    Move,
    Object,
    Plan,
    Pose,
    Release,
    Task,
    Trajectory,
    load_robot,
)
from tests.checking.handmade import DOWN, OPEN, Hand, above, carry, two_boxes
from tests.checking.mutations.handling import lies_tilted_across_two_trays
from tests.checking.test_carried_astray import calm
from tests.task.meshes import parts_obj

HOME = load_robot("panda").home
TIP = 0.00885
"""Of open fingers under the tool [m]."""
TILT, ENDS, PIVOT, THICK = 0.08, (-0.15, 0.12), 0.012, 0.03
"""Of what rocks: how far it is tilted [rad]; its ends, where it rocks over, and how thick it is there [m]."""


def tilted(tilt: float) -> np.ndarray:
    """The turn of what rocks, about where it does."""
    over, T = np.array([PIVOT, 0.0, 0.0]), Pose.from_rpy((0.0, 0.0, 0.0), (0.0, tilt, 0.0)).matrix
    T[:3, 3] = over - T[:3, :3] @ over
    return T


def rocker(folder, *, handle: bool = False, tilt: float = TILT) -> tuple[Object, np.ndarray]:
    """What lies on the lesser of two facets of its underside, tilted, and would not do so by itself; and its pose.

    With a handle it is of two pieces.
    """
    (left, right), slope = ENDS, np.tan(tilt)
    side = [(left, 0.0), (PIVOT, 0.0), (right, (right - PIVOT) * slope), (right, THICK + (right - left) * slope)]
    corners = [(x, y, z) for x, z in (*side, (left, THICK)) for y in (-0.02, 0.02)]
    pieces = [trimesh.convex.convex_hull(np.array(corners))]
    if handle:
        pieces.append(trimesh.creation.box((0.02, 0.02, 0.03)))
        pieces[1].apply_translation((-0.1, 0.0, THICK + (-0.1 - left) * slope + 0.012))
    T = Pose((0.05, -0.1, 0.0)).matrix @ tilted(tilt)
    return Object("rocker", written(folder / "rocker.obj", pieces), Pose.from_matrix(T), mass=0.15), T


def written(file, pieces) -> Mesh:
    """A mesh of convex pieces, in a file."""
    lines, count = list[str](), 1
    for number, piece in enumerate(pieces):
        lines += [f"g piece_{number}", *("v {:.6f} {:.6f} {:.6f}".format(*vertex) for vertex in piece.vertices)]
        lines += ["f {} {} {}".format(*face) for face in piece.faces + count]
        count += len(piece.vertices)
    file.write_text("\n".join(lines))
    return Mesh(str(file))


def on_top(T: np.ndarray, x: float) -> np.ndarray:
    """A place on the top of what rocks."""
    return (T @ [x, 0.0, THICK + (x - ENDS[0]) * np.tan(TILT), 1.0])[:3]


def led_over(hand: Hand, place: tuple[float, float, float]) -> Action:
    """Open fingers go along y over a place."""
    ends = [Pose((place[0], place[1] + y, place[2]), DOWN) for y in (-0.12, 0.12)]
    ways = [hand.free(above(ends[0])), *(hand.line(to) for to in (*ends, above(ends[1])))]
    slow = [Trajectory(way.times * 3.0, way.positions, way.velocities / 3.0) for way in ways]
    return Action("move", (), tuple(Move("transit", way, OPEN) for way in slow))


@pytest.mark.parametrize(("over", "met"), [(0.003, True), (0.012, False)])
def test_what_lies_down_when_a_weight_leaves_it_is_met_where_it_lies(tmp_path, over, met):
    """Fingers pass low over the end that has come up: it ended 124 and 149 mm off in two simulators."""
    thing, T = rocker(tmp_path)
    top, goal = on_top(T, 0.08), Pose((0.05, 0.2, 0.03))
    start = Pose((*top[:2], top[2] + 0.03))
    weight = Object("weight", Box((0.04, 0.04, 0.06)), start, At(goal), mass=0.8)
    hand = Hand(HOME)
    actions = carry(hand, "weight", start, goal, 0.04, ("rocker", "table"))
    actions.append(led_over(hand, (0.155, -0.1, top[2] + TIP + over)))
    task = Task("rocks", (thing, weight))
    plan = Plan("rocks", "panda", 0, {"rocker": thing.pose, "weight": start}, HOME, {"weight": goal}, calm(actions))
    found = [problem.sentence for problem in check(task, plan).problems]
    assert any("finger meets rocker" in sentence for sentence in found) == met, found
    assert bool(found) == met, found


def test_what_stands_on_what_gives_way_is_taken_along(tmp_path):
    thing, T = rocker(tmp_path)
    things = [thing]
    for name, x in (("weight", 0.08), ("rider", 0.03)):
        at = T.copy()
        at[:3, 3] = on_top(T, x)
        at = at @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, -TILT, 0.0)).matrix @ Pose((0.0, 0.0, 0.01)).matrix
        mass = 0.8 if name == "weight" else 0.01
        things.append(Object(name, Box((0.02, 0.02, 0.02)), Pose.from_matrix(at), mass=mass))
    state, said = State({o.name: o.pose.matrix for o in things}, np.array(HOME), OPEN), list[str]()
    scene = Scene.of(Task("rides", tuple(things)))
    check_uncovered(scene, state, "weight", DEFAULT, lambda _, sentence, **about: said.append(sentence))
    assert not said
    assert sorted(state.follows) == ["rider", "rocker"]
    came = {name: state.follows[name] @ np.linalg.inv(state.poses[name]) for name in state.follows}
    assert np.allclose(came["rider"], came["rocker"], atol=1e-4)
    assert state.follows["rider"][2, 3] > state.poses["rider"][2, 3] + 0.001


@pytest.mark.parametrize(("turn", "wide", "said_of"), [(0.03, 0.03, ""), (0.0, 0.037, "fills")])
def test_what_lies_turned_is_gripped_where_pads_draw_it_to(turn, wide, said_of):
    """A bar stays turned about its middle, so that it is 3 mm aside where it is gripped: pads draw it between them."""
    bar = Object("bar", Box((0.25, wide, 0.03)), Pose((0.05, 0.0, 0.015)))
    hand, scene, found = Hand(HOME), Scene.of(Task("turned", (bar,))), list[str]()
    pick = carry(hand, "bar", bar.pose, bar.pose, 0.03, ("table", "table"), aside=0.1)[1]
    reach, grip, _ = pick.steps
    state = State({"bar": bar.pose.matrix}, reach.trajectory.positions[-1], OPEN)
    state.stayed["bar"] = bar.pose.matrix @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, turn)).matrix
    check_grip(scene, state, grip, DEFAULT, lambda _, sentence, **about: found.append(sentence))
    assert any(said_of in sentence for sentence in found) == bool(said_of), found


@pytest.mark.parametrize("handle", [False, True])
@pytest.mark.parametrize(("x", "over", "wrong"), [(0.05, 0.003, True), (0.05, 0.02, False), (-0.03, 0.003, False)])
def test_what_gives_way_to_what_is_put_on_it_is_met_where_it_has_come_to(tmp_path, x, over, wrong, handle):
    """The same rocks under what is put on its end, and the other end comes up: 196 and 107 mm off in two simulators."""
    thing, _ = rocker(tmp_path, handle=handle)
    T = Pose((0.05, -0.1, 0.0))
    thing = replace(thing, pose=T)
    top, slope = on_top(T.matrix, x), Pose.from_rpy((0.0, 0.0, 0.0), (0.0, -TILT, 0.0))
    start, goal = Pose((0.05, 0.2, 0.03)), Pose(tuple(top), slope.quat) @ Pose((0.0, 0.0, 0.03))
    weight = Object("weight", Box((0.04, 0.04, 0.06)), start, At(goal), mass=0.8)
    hand = Hand(HOME)
    actions = carry(hand, "weight", start, goal, 0.04, ("table", "rocker"))
    left = on_top(T.matrix, ENDS[0] + 0.015)
    actions.append(led_over(hand, (left[0], -0.1, left[2] + TIP + over)))
    task = Task("rocks", (thing, weight))
    plan = Plan("rocks", "panda", 0, {"rocker": T, "weight": start}, HOME, {"weight": goal}, calm(actions))
    found = [problem.sentence for problem in check(task, plan).problems]
    assert any("finger meets rocker" in sentence for sentence in found) == wrong, found
    assert bool(found) == wrong, found


@pytest.mark.parametrize(("tilt", "refused"), [(0.16, True), (0.12, True), (0.03, False), (0.0, False)])
def test_what_is_let_go_tilted_in_a_tray_stays_so_or_is_refused(tmp_path, tilt, refused):
    """Two simulators have it come down by 15, 11, 2.7 and 0.3 mm; both bodies are of several pieces."""
    thing, _ = rocker(tmp_path, handle=True, tilt=tilt or TILT)
    T = Pose((0.05, -0.1, 0.05)).matrix @ tilted(tilt)
    floor, wall = ((-0.2, -0.1, 0.0), (0.2, 0.1, 0.05)), ((-0.2, 0.1, 0.0), (0.2, 0.12, 0.1))
    (tmp_path / "tray.obj").write_text(parts_obj([floor, wall]))
    tray = Object("tray", Mesh(str(tmp_path / "tray.obj")), Pose((0.05, -0.1, 0.0)), mass=2.0)
    state = State({"rocker": T, "tray": tray.pose.matrix}, np.array(HOME), OPEN)
    said = list[str]()
    scene = Scene.of(Task("lain", (thing, tray)))
    check_rest(scene, state, "rocker", DEFAULT, lambda _, sentence, **about: said.append(sentence))
    assert any("does not stay where it is let go" in sentence for sentence in said) == refused, said
    assert bool(said) == refused, said


def banana(folder, radius: float, arc: float, thick: float, count: int) -> Mesh:
    """An arc of pieces of five sides that is thinner at its ends, each piece convex."""
    ends = list[np.ndarray]()
    for angle in np.linspace(-arc / 2, arc / 2, count + 1):
        center = radius * np.array([np.sin(angle), 0.0, 1.0 - np.cos(angle)])
        up, size = np.array([-np.sin(angle), 0.0, np.cos(angle)]), thick * (1.0 - abs(angle) / arc)
        round_it = 2 * np.pi * np.arange(5)[:, None] / 5
        ends.append(center + size * (np.cos(round_it) * up + np.sin(round_it) * np.array([0.0, 1.0, 0.0])))
    pieces = [trimesh.convex.convex_hull(np.vstack(pair)) for pair in pairwise(ends)]
    return written(folder / "banana.obj", pieces)


BLOCK = Object("block", Box((0.16925, 0.0945, 0.05242)), Pose((0.05, 0.0, 0.02621)), mass=3.0)
BLOCKS = [Object(f"block{x}", Box((0.04, 0.08, 0.0461)), Pose((x, 0.0, 0.02305)), mass=3.0) for x in (-0.0008, 0.1008)]
WALL = Object("wall", Box((0.03, 0.2, 0.05545)), Pose((0.11462, 0.0, 0.027725)), mass=5.0)


@pytest.mark.parametrize(
    ("shape", "xyz", "quat", "friction", "others", "refused"),
    [
        (
            (0.0736, 1.562, 0.01264, 4),
            (0.04589, 0.00858, 0.04861),
            (-0.1006, 0.5558, 0.782, -0.2635),
            0.3,
            BLOCKS,
            True,
        ),
        (
            (0.0973, 1.228, 0.01284, 5),
            (0.03927, 0.02449, 0.06471),
            (-0.0566, -0.1517, -0.3452, 0.9245),
            1.0,
            [BLOCK],
            True,
        ),
        (
            (0.0837, 1.976, 0.01463, 4),
            (0.08507, -0.02289, 0.01206),
            (-0.352, -0.4907, 0.574, 0.5531),
            1.0,
            [WALL],
            True,
        ),
        ((0.0736, 1.562, 0.01264, 4), (0.05, 0.0, 0.05462), (0.7071, 0.0, 0.0, 0.7071), 0.3, BLOCKS, False),
    ],
)
def test_what_is_let_go_aslant_on_several_bodies_or_an_edge_is_refused(
    tmp_path, shape, xyz, quat, friction, others, refused
):
    """Two simulators have the first three end 33 to 35, 14, and 27 mm off, and the last stay."""
    it = Object("it", banana(tmp_path, *shape), Pose(xyz, quat), mass=0.05, friction=friction)
    scene, said = Scene.of(Task("let_go", (*others, it))), list[str]()
    state = State({thing.name: thing.pose.matrix for thing in scene.task.objects}, np.array(HOME), OPEN)
    check_rest(scene, state, "it", DEFAULT, lambda _, sentence, **about: said.append(sentence))
    assert any("does not stay where it is let go" in sentence for sentence in said) == refused, said
    assert bool(said) == refused, said


def test_what_is_let_go_half_a_millimetre_beyond_what_carries_it_is_refused():
    """It turns by 0.19 rad in two simulators, 18 mm off; friction, by a fifth more than is given, was to hold it."""
    mutant = lies_tilted_across_two_trays(*two_boxes(), np.random.default_rng((720, 41, 0)))
    assert any("does not stay where it is let go" in str(problem) for problem in check(*mutant).problems)


def test_what_gives_way_to_what_is_put_on_it_takes_that_from_its_goal(tmp_path):
    """Both are 5.4 mm off in two simulators, and 6 mm by the checker."""
    thing, _ = rocker(tmp_path)
    T = Pose((0.05, -0.1, 0.0))
    top, slope = on_top(T.matrix, 0.04), Pose.from_rpy((0.0, 0.0, 0.0), (0.0, -TILT, 0.0))
    goal = Pose(tuple(top), slope.quat) @ Pose((0.0, 0.0, 0.03))
    weight = Object("weight", Box((0.04, 0.04, 0.06)), goal, mass=0.8)
    scene = Scene.of(Task("rocks", (replace(thing, pose=T), weight)))
    state, said = State({"rocker": T.matrix, "weight": goal.matrix}, np.array(HOME), OPEN), list[str]()
    check_rest(scene, state, "weight", DEFAULT, lambda _, sentence, **about: said.append(sentence))
    assert not said
    off = scene.displacement("weight", state.given["weight"].pose, goal.matrix)
    assert off == pytest.approx(0.0055, abs=0.001)


@pytest.fixture(scope="module")
def laid_down(tmp_path_factory):
    """A weight is taken from what rocks, which lies down: the task, the plan, and where it comes to."""
    thing, T = rocker(tmp_path_factory.mktemp("rocker"))
    top, goal = on_top(T, 0.08), Pose((0.05, 0.2, 0.03))
    start = Pose((*top[:2], top[2] + 0.03))
    task = Task("rocks", (thing, Object("weight", Box((0.04, 0.04, 0.06)), start, At(goal), mass=0.8)))
    actions = calm(carry(Hand(HOME), "weight", start, goal, 0.04, ("rocker", "table")))
    plan = Plan("rocks", "panda", 0, {"rocker": thing.pose, "weight": start}, HOME, {"weight": goal}, actions)
    state = check(task, plan).state
    assert state.came == {"rocker"}
    return task, plan, Pose.from_matrix(state.stayed["rocker"])


def falling(plan: Plan, at: int, name: str, pose: Pose) -> Plan:
    """The plan with a fall at the end of one of its actions."""
    actions = list(plan.actions)
    actions[at] = replace(actions[at], steps=(*actions[at].steps, Fall(name, pose)))
    return replace(plan, actions=tuple(actions))


def test_a_plan_may_say_where_what_gave_way_has_come_to(laid_down):
    task, plan, there = laid_down
    verdict = check(task, falling(plan, -1, "rocker", there))
    assert verdict.accepted, verdict
    assert np.allclose(verdict.state.poses["rocker"], there.matrix)
    assert not verdict.state.came and "rocker" not in verdict.state.stayed


@pytest.mark.parametrize(
    ("at", "name", "aside", "said_of"),
    [
        (-1, "rocker", 0.002, "comes to rest 2.0 mm from where it is said to"),
        (0, "rocker", 0.0, "nothing lets it"),  # the weight is still on it
        (-1, "post", 0.0, "the task knows no post"),
    ],
)
def test_nothing_comes_to_rest_elsewhere_because_a_plan_says_so(laid_down, at, name, aside, said_of):
    task, plan, there = laid_down
    pose = Pose((there.xyz[0] + aside, *there.xyz[1:]), there.quat)
    verdict = check(task, falling(plan, at, name, pose))
    assert not verdict.executable
    assert any(said_of in problem.sentence for problem in verdict.problems), verdict


def test_what_was_said_to_have_given_way_may_not_do_so_again(laid_down):
    task, plan, there = laid_down
    twice = falling(falling(plan, -1, "rocker", there), -1, "rocker", there)
    assert any("nothing lets it" in problem.sentence for problem in check(task, twice).problems)


@pytest.mark.parametrize("told", [True, False])
def test_what_gave_way_is_gripped_where_the_plan_says_that_it_has_come_to(laid_down, told):
    """It has come up by 5 mm there: a plan that does not know does not grip it as it is said to lie, turned."""
    task, plan, there = laid_down
    hand = Hand(tuple(plan.actions[-1].steps[-1].trajectory.positions[-1].tolist()))
    pick = carry(hand, "rocker", there, there, 0.04, ("table", "table"), grip_height=0.02)[:2]
    known = falling(plan, -1, "rocker", there) if told else plan
    found = check(task, replace(known, actions=(*known.actions, *calm(pick)))).problems
    assert any(problem.kind == "grasp" for problem in found) != told, found


@pytest.mark.parametrize(("over", "wrong"), [(0.003, True), (0.012, False)])
def test_what_comes_up_as_fingers_leave_that_have_let_something_go_is_met(tmp_path, over, wrong):
    """A weight goes from what rocks to a shelf beside it, and a finger is over its end until the weight is let go."""
    thing, T = rocker(tmp_path)
    top, aside = on_top(T, 0.07), 0.046
    start = Pose((*top[:2], top[2] + 0.015))
    goal = Pose((top[0], top[1] + aside, top[2] + 0.015))
    weight = Object("weight", Box((0.03, 0.04, 0.03)), start, At(goal), mass=0.8)
    shelf = Object("shelf", Box((0.03, 0.04, top[2])), Pose((top[0], top[1] + aside, top[2] / 2)), mass=3.0)
    T_object_tool = Pose((0.0, 0.0, 0.002 + TIP - 0.015), DOWN)
    held, hand = Attachment("weight", T_object_tool.inverse()), Hand(HOME)
    before, after = start @ T_object_tool, goal @ T_object_tool
    touching = frozenset({("robot", "weight"), ("weight", "rocker"), ("weight", "shelf")})
    raised = [Pose((at.xyz[0], at.xyz[1], at.xyz[2] + 0.001), at.quat) for at in (before, after)]
    actions = [Action("move", (), (Move("transit", hand.free(above(before)), OPEN),))]
    approach = Move("approach", hand.line(before), OPEN, contacts=touching)
    lift, across = (Move("lift", hand.line(to), 0.04, held, touching) for to in raised)
    lower = Move("lower", hand.line(after), 0.04, held, touching)
    retreat = Move("retreat", hand.line(above(after)), OPEN, contacts=touching)
    actions.append(Action("unstack", ("weight", "rocker"), (approach, Grip(held, 0.04), lift, across)))
    actions.append(Action("stack", ("weight", "shelf"), (lower, Release("weight", goal, OPEN), retreat)))
    actions.append(led_over(hand, (0.155, -0.1, top[2] + TIP + over)))
    task = Task("rocks", (thing, shelf, weight))
    poses = {each.name: each.pose for each in task.objects}
    plan = Plan("rocks", "panda", 0, poses, HOME, {"weight": goal}, calm(actions))
    found = [problem.sentence for problem in check(task, plan).problems]
    assert any("finger meets rocker" in sentence for sentence in found) == wrong, found
    assert bool(found) == wrong, found
