"""Corruptions that handle something else instead, alone on the table, and say of it what is not so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import HalfspaceIntersection

from tamp.task import Action, Attachment, Box, Fall, Grip, Move, Object, Plan, Pose, Release, Task, Trajectory
from tamp.task.mesh.parts import convex_hull
from tests.checking.handmade import DOWN, OPEN, Hand, above, carry
from tests.checking.mutations.editing import Pair
from tests.checking.mutations.solids import hulls
from tests.checking.physics.heaps import PUT_ON_LEANING, TAKEN_FROM_LEANING
from tests.checking.physics.hollow_heaps import PUT_ON_HOLLOW

CARD, BAR, BRICK = Box((0.004, 0.05, 0.12)), Box((0.2, 0.05, 0.06)), Box((0.04, 0.05, 0.1))
DOMINO = Box((0.012, 0.05, 0.1))
CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)])
AGAINST_A_DOMINO = "a box that tips against a domino, which leans on the slab under it"
BESIDE_A_ROD = "slab that leans on a ball, and by its edge on a rod that it does not touch"
TIP = 0.00885  # of open fingers under the tool [m]
CALM = 1.3  # times as long as the arm's limits ask


def hangs_lower_than_said(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A bar is said to be higher in the hand than it is, or to have one end higher, and passes over a card so."""
    if task.robot != "panda":
        return None
    place = tuple(rng.uniform((0.0, -0.2), (0.1, 0.1)))
    hand, start = Hand(plan.home), Pose((*place, BAR.size[2] / 2))
    tilted, deep = bool(rng.integers(2)), rng.uniform(0.0007, 0.0009)
    said = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, rng.uniform(0.0125, 0.0135), 0.0))
    held = Pose((0.0, 0.0, 0.0), DOWN) @ (said if tilted else Pose((0.0, 0.0, rng.uniform(0.0016, 0.0019))))
    pick, away, back = (start @ Pose((0.0, 0.0, 0.0), DOWN) for _ in range(3))
    high = CARD.size[2] - deep + BAR.size[2] / 2
    away, back = (Pose((place[0], place[1] + by, high), DOWN) for by in (0.25, 0.0))
    attachment, touching = Attachment("bar", held), frozenset({("robot", "bar"), ("bar", "table")})
    reach = [Move("transit", hand.free(above(pick)), OPEN), Move("approach", hand.line(pick), OPEN, contacts=touching)]
    lift = Move("lift", hand.line(back), BAR.size[1], attachment, touching)
    # over the card, which is thin across the way of the bar, and back again
    across = [Move("transfer", hand.line(to), BAR.size[1], attachment) for to in (away, back)]
    lower = Move("lower", hand.line(pick), BAR.size[1], attachment, touching)
    release = Release("bar", start, OPEN)
    leave = Move("retreat", hand.line(above(pick)), OPEN, contacts=touching)
    actions = [
        Action("move", (), (reach[0],)),
        Action("pick", ("bar",), (reach[1], Grip(attachment, BAR.size[1]), lift)),
        Action("move", ("bar",), tuple(across)),
        Action("place", ("bar",), (lower, release, leave)),
    ]
    far = (place[0] - 0.09 if tilted else place[0] + rng.uniform(-0.06, 0.06), place[1] + 0.14)
    card = Object("card", CARD, Pose.from_rpy((*far, CARD.size[2] / 2), (0.0, 0.0, np.pi / 2)), mass=0.1)
    return instead(task, plan, actions, Object("bar", BAR, start, mass=0.3), card)


def met_where_it_was_let_go(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A domino is let go twice beside where it is said to stand, and a brick is put down there."""
    if task.robot != "panda":
        return None
    place = tuple(rng.uniform((0.0, -0.2), (0.1, 0.1)))
    hand, actions = Hand(plan.home), list[Action]()
    start = stands = Pose((*place, DOMINO.size[2] / 2))
    for _ in range(2):
        *gone, put_down = carry(hand, "domino", stands, stands, DOMINO.size[1], ("table", "table"), 0.03)
        stands = Pose((stands.xyz[0] + rng.uniform(0.0018, 0.0019), *stands.xyz[1:]))
        lower, release, leave = put_down.steps
        actions += [*gone, replace(put_down, steps=(lower, replace(release, pose=stands), leave))]
    first, gap = Pose((place[0] + 0.1, place[1], BRICK.size[2] / 2)), rng.uniform(0.0004, 0.0012)
    beside = Pose((stands.xyz[0] - DOMINO.size[0] / 2 - BRICK.size[0] / 2 - gap, *first.xyz[1:]))
    actions += carry(hand, "brick", first, beside, BRICK.size[1], ("table", "table"), 0.03)
    return instead(task, plan, actions, Object("domino", DOMINO, start), Object("brick", BRICK, first))


def rocks_over_its_foot(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What stands on a foot far to one side is let go on that edge of it, falls flat, and rocks over the other one."""
    if task.robot != "panda":
        return None
    place = tuple(rng.uniform((0.0, -0.2), (0.1, 0.1)))
    hand, within, tilt = Hand(plan.home), rng.uniform(0.0025, 0.0035), rng.uniform(0.2, 0.3)
    shape, edge, middle = on_a_foot(within)
    start = Pose((*place, 0.0))
    about, gripped = Pose((edge, 0.0, 0.0)), Pose((0.0, 0.0, middle), DOWN)
    leans = start @ about @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, tilt, 0.0)) @ about.inverse()
    held, tool, tipped = Attachment("footed", gripped.inverse()), start @ gripped, leans @ gripped
    touching, width = frozenset({("robot", "footed"), ("footed", "table")}), 0.06
    reach = [Move("transit", hand.free(above(tool)), OPEN), Move("approach", hand.line(tool), OPEN, contacts=touching)]
    lift = Move("lift", hand.line(above(tool, 0.05)), width, held, touching)
    turn = Move("transfer", hand.turned(above(tipped, 0.05)), width, held)
    lower = Move("lower", hand.line(tipped), width, held, touching)
    leave = Move("retreat", hand.line(above(tipped)), OPEN, contacts=touching)
    actions = [
        Action("move", (), (reach[0],)),
        Action("pick", ("footed",), (reach[1], Grip(held, width), lift)),
        Action("move", ("footed",), (turn,)),
        Action("lay", ("footed",), (lower, Release("footed", leans, OPEN), leave, Fall("footed", start))),
    ]
    return instead(task, plan, actions, Object("footed", shape, start, mass=0.2))


def rocks_under_what_is_put_on_it(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What lies on the greater of two facets gets a weight on its other end; fingers pass low over this one."""
    if task.robot != "panda":
        return None
    x, y, slope = *rng.uniform((0.03, -0.15), (0.1, -0.05)), np.tan(rng.uniform(0.07, 0.1))
    left, pivot, right, thick = -0.15, 0.012, 0.12, 0.03
    side = [(left, 0.0), (pivot, 0.0), (right, (right - pivot) * slope), (right, thick + (right - left) * slope)]
    corners = np.array([(a, b, c) for a, c in (*side, (left, thick)) for b in (-0.02, 0.02)])
    pieces = [convex_hull(corners)]
    if rng.integers(2):  # with a handle it is of two pieces
        handle = (-0.03, 0.0, thick + (-0.03 - left) * slope + 0.01)
        pieces.append(convex_hull((CORNERS - (0.0, 0.0, 0.5)) * (0.02, 0.02, 0.03) + handle))
    shape = hulls(f"rocker_{slope:.6f}_{len(pieces)}", pieces)
    rocker = Object("rocker", shape, Pose((x, y, 0.0)), mass=0.15)
    at = rng.uniform(0.045, 0.055)
    flush = Pose.from_rpy((x + at, y, thick + (at - left) * slope), (0.0, -float(np.arctan(slope)), 0.0))
    weight, start, goal = Box((0.04, 0.04, 0.06)), Pose((x, y + 0.3, 0.03)), flush @ Pose((0.0, 0.0, 0.03))
    hand = Hand(plan.home)
    actions = carry(hand, "weight", start, goal, 0.04, ("table", "rocker"))
    over = (x + left + 0.012, thick + TIP + rng.uniform(0.002, 0.004))
    ends = [Pose((over[0], y + by, over[1]), DOWN) for by in (-0.12, 0.12)]
    ways = [hand.free(above(ends[0])), *(hand.line(to) for to in (*ends, above(ends[1])))]
    actions.append(Action("move", (), tuple(Move("transit", way, OPEN) for way in ways)))
    return instead(task, plan, actions, rocker, Object("weight", weight, start, mass=0.8))


def takes_a_board_over_the_rim(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A weight is put on a board so that both have their middle a fifth of a millimetre beyond what carries."""
    if task.robot != "panda":
        return None
    x, y, beyond = *rng.uniform((0.0, -0.15), (0.08, -0.05)), rng.uniform(1.2e-4, 2e-4)
    block = Object("block", Box((0.04, 0.04, 0.03)), Pose((x, y, 0.015)), mass=1.0)
    board = Object("board", Box((0.16, 0.04, 0.006)), Pose((x, y, 0.033)), mass=rng.uniform(0.05, 0.2))
    mass, start = rng.uniform(0.1, 0.3), Pose((x, y + 0.3, 0.03))
    at = (0.02 + beyond) * (board.mass + mass) / mass
    goal = Pose((x + at, y, 0.066))
    actions = carry(Hand(plan.home), "weight", start, goal, 0.04, ("table", "board"))
    return instead(task, plan, actions, block, board, Object("weight", Box((0.03, 0.04, 0.06)), start, mass=mass))


def lies_tilted_in_a_tray(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """What has two facets under it, and a handle, is let go on the lesser one, by which it lies tilted, in a tray."""
    return _lies_tilted(task, plan, rng, two=False)


def lies_tilted_across_two_trays(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """The same where the lesser facet lies on two trays that stand end to end."""
    return _lies_tilted(task, plan, rng, two=True)


def _lies_tilted(task: Task, plan: Plan, rng: np.random.Generator, *, two: bool) -> Pair | None:
    if task.robot != "panda":
        return None
    (x, y), tilt = rng.uniform((0.0, -0.15), (0.08, -0.05)), rng.uniform(0.16, 0.19)
    left, pivot, right, thick, slope = -0.15, 0.012, 0.12, 0.03, np.tan(tilt)
    side = [(left, 0.0), (pivot, 0.0), (right, (right - pivot) * slope), (right, thick + (right - left) * slope)]
    corners = np.array([(a, b, c) for a, c in (*side, (left, thick)) for b in (-0.02, 0.02)])
    high = thick + (pivot - left) * slope
    handle = convex_hull((CORNERS - (0.0, 0.0, 0.5)) * (0.02, 0.02, 0.04) + (pivot, 0.0, high + 0.015))
    shape = hulls(f"handled_{tilt:.6f}", [convex_hull(corners), handle])
    over, turn = Pose((pivot, 0.0, 0.0)), Pose.from_rpy((0.0, 0.0, 0.0), (0.0, tilt, 0.0))
    start, goal = Pose((x, y + 0.3, 0.0)), Pose((x, y, 0.0205)) @ over @ turn @ over.inverse()
    actions = carry(Hand(plan.home), "handled", start, goal, 0.02, ("table", "left"), high + 0.02, pivot)
    cut = pivot + rng.uniform(0.03, 0.06)
    slabs = [(-0.18, cut), (cut + 0.002, 0.18)] if two else [(-0.18, 0.18)]
    things = [Object("handled", shape, start, mass=0.1)]
    for name, (begins, ends) in zip(("left", "right"), slabs, strict=False):
        long, at = ends - begins, (begins + ends) / 2
        boxes = [((long, 0.12, 0.02), (0.0, 0.0, 0.0)), ((long, 0.01, 0.03), (0.0, 0.065, 0.0))]
        tray = hulls(f"{name}_{long:.6f}", [convex_hull(CORNERS * size + aside) for size, aside in boxes])
        things.append(Object(name, tray, Pose((x + at, y, 0.0)), mass=2.0))
    return instead(task, plan, actions, *things)


def tips_off_a_rim(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A cup is let go on the rim of a bowl that leans, upside down, on a jar, its middle beside all that it touches."""
    if task.robot != "panda":
        return None
    (x, y), yaw = rng.uniform((0.03, -0.12), (0.06, -0.08)), rng.uniform(-np.pi / 2, 0.0)
    there, start = Pose.from_rpy((x, y, 0.0), (0.0, 0.0, yaw)), Pose((x, y + 0.35, 0.03))
    things = [replace(o, pose=there @ o.pose) for o in PUT_ON_HOLLOW["cup on a bowl that leans on a jar, upside down"]]
    bowl, cup = things[1], things[2]
    actions = carry(Hand(plan.home), cup.name, start, cup.pose, 0.0438, ("table", bowl.name), 0.012)
    return instead(task, plan, actions, *things[:2], replace(cup, pose=start))


def tips_against_what_leans(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A box is let go on the edge of a slab that slopes, tips down on it, and pushes a domino off that leans on it."""
    if task.robot != "panda":
        return None
    there, start = Pose((*rng.uniform((-0.03, 0.1), (0.03, 0.15)), 0.0)), Pose((0.05, -0.25, 0.009))
    *things, box = [replace(o, pose=there @ o.pose) for o in PUT_ON_LEANING[AGAINST_A_DOMINO]]
    actions = carry(Hand(plan.home), box.name, start, box.pose, 0.06, ("table", "slab"), 0.004)
    return instead(task, plan, actions, *things, replace(box, pose=start))


def takes_a_prop_away(task: Task, plan: Plan, rng: np.random.Generator) -> Pair | None:
    """A prop is taken from under a slab that leans on it, with another on that, by whose edge a rod leans."""
    if task.robot != "panda":
        return None
    there = Pose((*rng.uniform((0.05, -0.05), (0.1, 0.05)), 0.0))
    ball, *things = TAKEN_FROM_LEANING[BESIDE_A_ROD]
    prop, wide = _prop(things[1], ball.pose.xyz, rng)
    start = there @ prop.pose
    goal = Pose((start.xyz[0], start.xyz[1] - 0.25, 0.0))
    actions = carry(Hand(plan.home), "prop", start, goal, wide, ("table", "table"), 0.068, -0.01, out=-0.17)
    things = [replace(o, pose=there @ o.pose) for o in things]
    return instead(task, plan, actions, *things, replace(prop, pose=start))


def _prop(slab: Object, at: tuple[float, float, float], rng: np.random.Generator) -> tuple[Object, float]:
    """What fills a box beside a place as far as it is under a slab that leans there, and how wide it is [m]."""
    T, (begins, wide, low) = slab.pose.matrix, rng.uniform((-0.024, 0.018, 0.015), (-0.022, 0.026, 0.03))
    down, origin = T[:3, 2], np.array((*at[:2], 0.0))
    under = float(down @ (T[:3, 3] - origin)) - slab.shape.size[2] / 2 - 2.5e-5  # so far the slab's under side is off
    box = np.array([(-0.06, begins, 0.0), (low, begins + wide, 0.078)])
    faces = [[*down, -under], *np.column_stack([-np.eye(3), box[0]]), *np.column_stack([np.eye(3), -box[1]])]
    corners = HalfspaceIntersection(np.array(faces), box[0] + 0.004).intersections
    origin += (-0.04, begins + wide / 2, 0.0)
    corners -= (-0.04, begins + wide / 2, 0.0)
    shape = hulls(f"prop_{begins:.6f}_{wide:.6f}_{low:.6f}", [convex_hull(corners)])
    return Object("prop", shape, Pose(tuple(origin)), mass=0.3, friction=0.5), float(wide)


def on_a_foot(within: float):
    """A block on a foot whose near edge its centre of mass is so far within; the foot's far edge, a height to grip."""
    low, high, wide = 0.03, 0.1, 0.05
    # with a foot as wide as the block and `aside` of it, the centre is at aside low / (low + high)
    aside = (wide / 2 - within) * (low + high) / high
    pieces = [
        convex_hull((CORNERS * (wide, 0.06, tall)) + (x, 0.0, z))
        for x, z, tall in ((aside, 0.0, low), (0.0, low, high))
    ]
    return hulls(f"footed_{within:.6f}", pieces), aside + wide / 2, low + high - 0.02


def instead(task: Task, plan: Plan, actions: list[Action], *things: Object) -> Pair:
    """Things and actions in place of those of a task and its plan, without goals; free motions are calm."""
    start = {thing.name: thing.pose for thing in things}
    plan = replace(plan, start=start, goals={}, actions=tuple(_calm(action) for action in actions))
    return replace(task, objects=things, regions=()), plan


def _calm(action: Action) -> Action:
    steps = []
    for step in action.steps:
        if isinstance(step, Move):
            t = step.trajectory
            step = replace(step, trajectory=Trajectory(t.times * CALM, t.positions, t.velocities / CALM))
        steps.append(step)
    return replace(action, steps=tuple(steps))
