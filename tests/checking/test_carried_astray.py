"""What stands on something that is elsewhere than a plan says, by shifts that are each within tolerance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.checking import check
from tamp.checking.actions.left_standing import check_uncovered
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Action, At, Attachment, Box, Grip, Move, Object, Plan, Pose, Task, Trajectory, load_robot
from tests.checking.handmade import DOWN, Hand, above, carry
from tests.checking.mutations.editing import shifted

FRONT = 0.0264
"""Of closed fingers beside the tool [m]."""
HOME = load_robot("panda").home


def let_go_aside(
    hand: Hand, name: str, stands: Pose, by: float, grip_height: float = 0.005, on: str = "table"
) -> tuple[list[Action], Pose]:
    """Take an object up and put it down where it stands, twice, and say each time that it stands aside; and where."""
    actions = []
    for _ in range(2):
        *before, place = carry(hand, name, stands, stands, 0.05, (on, on), grip_height=grip_height)
        stands = Pose((stands.xyz[0] + by, *stands.xyz[1:]))
        lower, release, leave = place.steps
        actions += [*before, replace(place, steps=(lower, replace(release, pose=stands), leave))]
    return actions, stands


@pytest.mark.parametrize(("by", "within", "wrong"), [(1.9e-3, 3e-3, True), (1.9e-3, 6e-3, False), (0.0, 3e-3, False)])
def test_what_was_let_go_aside_twice_carries_nothing_on_its_edge(by, within, wrong):
    """A block is put down twice where it is not said to stand; what is put on its edge falls off it in a simulator."""
    hand, block, box = Hand(HOME), Box((0.06, 0.05, 0.06)), Box((0.04, 0.04, 0.05))
    start, first = Pose((0.05, 0.0, 0.03)), Pose((0.05, -0.25, 0.025))
    actions, stands = let_go_aside(hand, "block", start, by)
    goal = Pose((stands.xyz[0] + 0.03 - within, 0.0, 0.085))
    actions += carry(hand, "box", first, goal, 0.04, ("table", "block"), grip_height=0.0)
    task = Task("astray", (Object("block", block, start), Object("box", box, first, At(goal))))
    plan = Plan("astray", "panda", 0, {"block": start, "box": first}, HOME, {"box": goal}, tuple(actions))
    found = " ".join(problem.sentence for problem in check(task, plan).problems)
    assert ("box tips over where block stays" in found) == wrong, found


@pytest.mark.parametrize(("by", "gap", "wrong"), [(1.9e-3, 1.5e-3, True), (1.9e-3, 6e-3, False), (0.0, 1.5e-3, False)])
def test_what_was_let_go_aside_is_met_where_it_stands(by, gap, wrong):
    """A domino is let go twice beside where it is said to stand; what is put down there pushes it over."""
    hand, domino, box = Hand(HOME), Box((0.012, 0.05, 0.1)), Box((0.04, 0.05, 0.06))
    start, first = Pose((0.05, 0.0, 0.05)), Pose((0.05, -0.25, 0.03))
    actions, stands = let_go_aside(hand, "domino", start, by, grip_height=0.03)
    goal = Pose((stands.xyz[0] - 0.026 - gap, 0.0, 0.03))
    actions += carry(hand, "box", first, goal, 0.05, ("table", "table"))
    task = Task("astray", (Object("domino", domino, start), Object("box", box, first, At(goal))))
    plan = Plan("astray", "panda", 0, {"domino": start, "box": first}, HOME, {"box": goal}, tuple(actions))
    found = " ".join(problem.sentence for problem in check(task, plan).problems)
    assert ("box meets domino" in found or "box and domino" in found) == wrong, found


@pytest.mark.parametrize(("across", "wrong"), [(1.8e-3, True), (0.0, False)])
def test_what_pads_have_drawn_along_carries_nothing_on_its_edge(across, wrong):
    hand, block, box = Hand(HOME), Box((0.06, 0.05, 0.06)), Box((0.04, 0.04, 0.05))
    start, stands, first = Pose((0.05, -0.1, 0.03)), Pose((0.05, 0.1, 0.03)), Pose((0.05, -0.3, 0.025))
    goal = Pose((0.05, 0.1 + 0.025 - 0.0015, 0.085))
    actions = [
        *carry(hand, "block", start, stands, 0.05, ("table", "table"), across=across),
        *carry(hand, "box", first, goal, 0.04, ("table", "block"), grip_height=0.0),
    ]
    task = Task("drawn", (Object("block", block, start, At(stands)), Object("box", box, first, At(goal))))
    goals = {"block": stands, "box": goal}
    plan = Plan("drawn", "panda", 0, {"block": start, "box": first}, HOME, goals, tuple(actions))
    found = " ".join(problem.sentence for problem in check(task, plan).problems)
    assert ("box may be 1.8 mm aside" in found) == wrong, found


@pytest.mark.parametrize(("by", "wrong"), [(1.9e-3, True), (0.0, False)])
def test_what_is_pushed_from_where_it_is_not_said_to_stand_is_met_beside_its_path(by, wrong):
    """It is said to be 1.9 mm aside as each of two pushes begins; a domino was put down on its edge, and fell."""
    hand, actions, way = Hand(HOME), [], np.array([0.0, 0.06, 0.0])
    pushed, domino = Box((0.06, 0.06, 0.05)), Box((0.012, 0.05, 0.1))
    start, first = Pose((0.05, -0.1, 0.025)), Pose((0.15, -0.25, 0.05))
    stands = start
    for _ in range(2):
        tool = Pose((0.05, stands.xyz[1] - 0.03 - FRONT + 0.0015, 0.022), DOWN)
        back, stands = shifted(tool, -way / 2), shifted(stands, np.array([by, 0.0, 0.0]))
        go = Move("transit", hand.free(above(back)), 0.0)
        reach = [Move("approach", hand.line(to), 0.0) for to in (back, tool)]
        line = hand.line(shifted(tool, way))
        slow = Trajectory(line.times * 3, line.positions, line.velocities / 3)
        held = Attachment("pushed", tool.inverse() @ stands)
        push = Move("push", slow, 0.0, None, frozenset({("pushed", "table")}), held)
        leave = [Move("retreat", hand.line(shifted(to, way)), 0.0) for to in (back, above(back))]
        actions += [Action("move", (), (go,)), Action("slide", ("pushed", "table"), (*reach, push, *leave))]
        stands = shifted(stands, way)
    goal = Pose((stands.xyz[0] - 0.03 - 0.0008 - 0.006, stands.xyz[1], 0.05))
    actions += carry(hand, "domino", first, goal, 0.05, ("table", "table"), grip_height=0.03)
    things = (Object("pushed", pushed, start, At(stands), mass=0.3), Object("domino", domino, first, At(goal)))
    starts, goals = {"pushed": start, "domino": first}, {"pushed": stands, "domino": goal}
    plan = Plan("pushed", "panda", 0, starts, HOME, goals, tuple(actions))
    found = " ".join(problem.sentence for problem in check(Task("pushed", things), plan).problems)
    assert ("domino meets pushed" in found) == wrong, found
    assert bool(found) == wrong, found


def calm(actions: list[Action]) -> tuple[Action, ...]:
    """The same with a third more time for free motions."""

    def slower(step):
        if not isinstance(step, Move) or step.phase not in ("transit", "transfer"):
            return step
        path = step.trajectory
        return replace(step, trajectory=Trajectory(path.times * 1.3, path.positions, path.velocities / 1.3))

    return tuple(replace(action, steps=tuple(map(slower, action.steps))) for action in actions)


@pytest.mark.parametrize(
    ("by", "within", "wrong"), [(1.9e-3, 1.5e-3, True), (1.9e-3, 6e-3, False), (0.0, 1.5e-3, False)]
)
def test_what_was_let_go_aside_tips_with_what_is_put_on_its_end(by, within, wrong):
    """A board is let go twice farther out on a block than it is said to lie; a box that came on its end tipped it."""
    hand, lies, first = Hand(HOME), Pose((0.08, 0.0, 0.055)), Pose((0.05, -0.25, 0.025))
    actions, said = let_go_aside(hand, "board", lies, -by, on="block")
    masses = {"block": 2.0, "board": 0.4, "box": 0.2}
    end = Pose((0.1 + (0.4 * (0.1 - said.xyz[0]) - within * 0.6) / 0.2, 0.0, 0.095))
    actions += carry(hand, "box", first, end, 0.04, ("table", "board"), grip_height=0.0)
    shapes = {"block": Box((0.1, 0.1, 0.04)), "board": Box((0.2, 0.05, 0.03)), "box": Box((0.04, 0.04, 0.05))}
    starts = {"block": Pose((0.05, 0.0, 0.02)), "board": lies, "box": first}
    goals = {"box": end}
    things = tuple(Object(n, shapes[n], starts[n], At(end) if n in goals else None, mass=masses[n]) for n in shapes)
    plan = Plan("astray", "panda", 0, starts, HOME, goals, calm(actions))
    found = " ".join(problem.sentence for problem in check(Task("astray", things), plan).problems)
    assert ("board tips over" in found and "where board is in truth" in found) == wrong, found
    assert bool(found) == wrong, found


def pushed_on(
    hand: Hand,
    action: tuple[str, str, str],
    stands: Pose,
    far: float,
    high: float,
    aside: float = 0.0,
    half: float = 0.03,
) -> tuple[list[Action], Pose]:
    """Push a box, `half` as long along y, along that with a closed hand; and its end.

    The action names it, and what it stands on.
    """
    verb, name, on = action
    tool = Pose((stands.xyz[0] + aside, stands.xyz[1] - half - FRONT + 0.0015, high), DOWN)
    back, way = shifted(tool, np.array([0.0, -0.03, 0.0])), np.array([0.0, far, 0.0])
    go = Move("transit", hand.free(above(back)), 0.0)
    reach = [Move("approach", hand.line(to), 0.0) for to in (back, tool)]
    line = hand.line(shifted(tool, way))
    slow = Trajectory(line.times * 3, line.positions, line.velocities / 3)
    push = Move("push", slow, 0.0, None, frozenset({(name, on)}), Attachment(name, tool.inverse() @ stands))
    leave = [Move("retreat", hand.line(shifted(to, way)), 0.0) for to in (back, above(back))]
    actions = [Action("move", (), (go,)), Action(verb, (name, on), (*reach, push, *leave))]
    return actions, shifted(stands, way)


@pytest.mark.parametrize(("by", "within", "wrong"), [(1.9e-3, 2e-3, True), (1.9e-3, 7e-3, False), (0.0, 2e-3, False)])
def test_what_is_nudged_aslant_to_an_edge_may_be_beyond_it(by, within, wrong):
    """It is said to be nearer the middle as each of two nudges begins; it fell over the edge that they lead along."""
    hand, turn, actions = Hand(HOME), np.radians(20.0), list[Action]()
    x = 0.05 + (0.05 - within - 0.04 * np.sin(turn)) / np.cos(turn)
    start = stands = Pose((float(x) + 2 * by, 0.0, 0.05))
    for k in range(2):
        stands = Pose((stands.xyz[0] - by, *stands.xyz[1:]))
        more, stands = pushed_on(hand, ("nudge", "box", "slab"), stands, 0.02, 0.04, by * (k + 1))
        actions += more
    slab = Object("slab", Box((0.1, 0.3, 0.03)), Pose.from_rpy((0.05, 0.0, 0.015), (0.0, 0.0, turn)), mass=2.0)
    box = Object("box", Box((0.06, 0.06, 0.04)), start, At(stands), mass=0.2)
    plan = Plan("aslant", "panda", 0, {"slab": slab.pose, "box": start}, HOME, {"box": stands}, calm(actions))
    found = " ".join(problem.sentence for problem in check(Task("aslant", (slab, box)), plan).problems)
    assert ("box may be 3.8 mm aside" in found) == wrong, found
    assert bool(found) == wrong, found


@pytest.mark.parametrize(
    ("said", "low", "wrong"),
    [
        (Pose((0.0, 0.0, 1.9e-3)), -1.4e-3, True),
        (Pose((0.0, 0.0, -1.9e-3)), 2.4e-3, False),
        (Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.014, 0.0)), -1.2e-3, True),
        (Pose((0.0, 0.0, 0.0)), 0.5e-3, False),
    ],
)
def test_what_hangs_lower_in_the_hand_than_it_is_said_to_is_met_there(said, low, wrong):
    """A bar is said to be higher in the hand, or to have one end higher; a domino that it should pass over fell."""
    hand, start, high = Hand(HOME), Pose((0.05, -0.2, 0.03)), 0.14
    tool, held = start @ Pose((0.0, 0.0, 0.0), DOWN), Attachment("bar", Pose((0.0, 0.0, 0.0), DOWN) @ said)
    before, after = (Pose((0.05, y, high + 0.03 + low), DOWN) for y in (-0.2, 0.2))
    touching = frozenset({("robot", "bar"), ("bar", "table")})
    go = Move("transit", hand.free(above(tool)), 0.08)
    reach = Move("approach", hand.line(tool), 0.08, contacts=touching)
    lift = Move("lift", hand.line(before), 0.05, held, touching)
    over = Move("transfer", hand.line(after), 0.05, held)
    steps = (("move", (), (go,)), ("pick", ("bar",), (reach, Grip(held, 0.05), lift)), ("move", (), (over,)))
    bar = Object("bar", Box((0.2, 0.05, 0.06)), start, mass=0.3)
    domino = Object("domino", Box((0.02, 0.012, high)), Pose((-0.038, 0.0, high / 2)), mass=0.05)
    starts = {"bar": bar.pose, "domino": domino.pose}
    plan = Plan("high", "panda", 0, starts, HOME, {}, calm([Action(*step) for step in steps]))
    found = [
        problem.sentence for problem in check(Task("high", (bar, domino)), plan).problems if problem.kind != "goal"
    ]
    assert any("domino meets bar" in sentence for sentence in found) == wrong, found
    assert bool(found) == wrong, found


@pytest.mark.parametrize(
    ("higher", "thick", "wrong"),
    [(1.9e-3, 1.5e-3, True), (1.9e-3, 4e-4, True), (0.0, 4e-4, True), (1.9e-3, 1e-4, False)],
)
def test_what_slides_does_not_pass_above_what_lies_in_its_way(higher, thick, wrong):
    """It is said to stand higher than it does as the push begins; the card that it should pass over came along."""
    start = Pose((0.05, -0.15, 0.025))
    actions, end = pushed_on(
        Hand(HOME), ("slide", "box", "table"), shifted(start, np.array([0, 0, higher])), 0.12, 0.02
    )
    box = Object("box", Box((0.06, 0.06, 0.05)), start, At(end), mass=0.3)
    card = Object("card", Box((0.06, 0.03, thick)), Pose((0.05, -0.0975, thick / 2)), mass=0.02)
    starts = {"box": start, "card": card.pose}
    plan = Plan("higher", "panda", 0, starts, HOME, {"box": end}, calm(actions))
    found = " ".join(problem.sentence for problem in check(Task("higher", (box, card)), plan).problems)
    assert ("card" in found) == wrong, found
    assert bool(found) == wrong, found


@pytest.mark.parametrize(("by", "wrong"), [(4e-3, True), (0.0, False)])
def test_what_is_in_truth_farther_out_tips_as_a_counterweight_is_taken_away(by, wrong):
    weight, plank, block = Box((0.03, 0.04, 0.06)), Box((0.2, 0.05, 0.02)), Box((0.05, 0.05, 0.06))
    at = {"block": (0.0, 0.0, 0.03), "plank": (0.0, 0.0, 0.07), "red": (0.0275, 0.0, 0.11), "green": (-0.05, 0.0, 0.11)}
    shapes, masses = dict(zip(at, (block, plank, weight, weight), strict=True)), (2.0, 0.05, 0.3, 0.3)
    things = [Object(n, shapes[n], Pose(at[n]), mass=m) for n, m in zip(at, masses, strict=True)]
    state, sentences = State({o.name: o.pose.matrix for o in things}, np.zeros(7)), list[str]()
    state.stayed["red"] = shifted(Pose(at["red"]), np.array([by, 0.0, 0.0])).matrix
    scene = Scene.of(Task("scales", tuple(things)))
    check_uncovered(scene, state, "green", DEFAULT, lambda _, sentence, **about: sentences.append(sentence))
    assert any("where red is in truth" in sentence for sentence in sentences) == wrong, sentences
    assert bool(sentences) == wrong
