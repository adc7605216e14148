"""Antipodal grasps of any mesh, best first.

Candidates pinch the object between two opposite contacts from many directions and at several depths. They are ranked
by what makes a grasp hold and reach: pad area in contact, leverage about the centre of mass, contact angle, upright
approach, and whether the hand is clear of table and neighbours both where the object stands and where it shall stand.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.clearance import (
    HINDERED,
    above_table,
    beneath,
    clear_of_falling,
    clear_of_object,
    hand_hits,
    neighbour_cost,
    standing_around,
    support_cost,
    tilt_cost,
)
from tamp.streams.closing import closed
from tamp.streams.enclosed import roomy_pinches
from tamp.streams.falls import letting_go
from tamp.streams.holding import FIRM, second_best
from tamp.streams.pinches import Pinches, intrinsic_cost
from tamp.streams.recall import recalled
from tamp.streams.slides import slidable
from tamp.streams.turning import turning
from tamp.streams.values import Grasp, Placement, falls_straight
from tamp.streams.workspace import Context, Workspace
from tamp.world.kinematics import inverse
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

ROUNDS = 8  # of sampling, where few grasps are clear at every placement
ENOUGH = 40  # clear grasps after which no further round is needed
SIEVED = 600  # pinches looked at closely in one round
PROMISING = 250  # of those, for which neighbours count
LIMIT = 160  # grasps offered for one object
FALLING = 10.0  # cost of a grasp from which the object falls straight, for each metre
LAID = 4.0  # cost of a grasp that can only lay the object down: more than that of any that puts it down


def sample_grasp(context: Context, obj: str) -> Iterator[Grasp]:
    """Yield grasps of obj, best first: those that serve start and goal, then those that serve one of them.

    They are ranked among the neighbours as they stood when they were first asked for.
    """
    if slidable(context.scene, obj, context.scene.start[obj]):
        context.fail(f"every hand that could grasp {obj} as it lies would reach into the table")
        return
    places = list(context.scene.placements_of(obj))
    key = ("grasps", obj, *places, str(context.rng.bit_generator.state))
    yield from recalled(context, key, lambda first: grasps_at(first, obj, places))


def grasps_at(context: Context, obj: str, places: list[Placement]) -> Iterator[Grasp | None]:
    """Yield grasps of obj, best first: those that serve all placements, then those that serve some of them.

    None stands for work done without a grasp, so that whoever waits for one can look at the clock.
    """
    workspace: Workspace = context.scene
    found, costs = yield from _candidates(context, workspace, obj, places)
    if len(costs):
        yield from _reachable_first(context, workspace, found, costs, obj, places)


def _candidates(
    context: Context, workspace: Workspace, obj: str, places: list[Placement]
) -> Generator[None, None, tuple[Pinches, NDArray[np.float64]]]:
    """Pinches and what speaks against each; sampled anew until enough of them are clear at every placement."""
    rounds: list[Pinches] = []
    costs: list[NDArray[np.float64]] = []
    for _ in range(ROUNDS):
        pinches, cost = _round(context, workspace, obj, places)
        rounds.append(pinches)
        costs.append(cost)
        if sum(int((cost < HINDERED).sum()) for cost in costs) >= ENOUGH:
            break
        yield None
    return Pinches.joined(rounds), np.concatenate(costs)


def _round(
    context: Context, workspace: Workspace, obj: str, places: list[Placement]
) -> tuple[Pinches, NDArray[np.float64]]:
    """One round of sampling: the promising pinches and their costs; neighbours are looked at only for those."""
    pinches = roomy_pinches(workspace, obj, places, context.rng)
    if not len(pinches):
        context.fail(f"{obj} has no two opposite surfaces within the gripper's stroke")
        return pinches, np.empty(0)
    pinches, serves, lays = _over_table(workspace, obj, pinches, places, context.rng)
    clear = clear_of_object(workspace, obj, pinches)
    pinches, serves, lays = pinches.at(clear), serves[:, clear], lays[:, clear]
    if not len(pinches):
        context.fail(f"the hand would hit the table or {obj} itself in every grasp of {obj}")
        return pinches, np.empty(0)
    cost = intrinsic_cost(workspace, obj, pinches)
    for place, usable, laid in zip(places, serves, lays, strict=True):
        upright = np.full(len(pinches), HINDERED)
        some = pinches.at(usable)
        upright[usable] = tilt_cost(some, place) + support_cost(workspace, some, obj, place)
        cost += np.minimum(upright, _fall_cost(workspace, obj, pinches, place, laid & (upright >= HINDERED)))
    promising = np.array(_spread(pinches, cost)[:PROMISING])
    pinches, cost = pinches.at(promising), cost[promising]
    for place in places:
        cost += neighbour_cost(workspace, pinches, obj, place)
    return pinches, cost


def _over_table(
    workspace: Workspace, obj: str, pinches: Pinches, places: list[Placement], rng: np.random.Generator
) -> tuple[Pinches, NDArray[np.bool_], NDArray[np.bool_]]:
    """Pinches whose hand stays above the table at one placement at least.

    Those that serve most placements are kept first: a uniform choice of a pool would lose them, since nine in ten
    of all hands reach into the table.

    Returns:
        The pinches; which placements each serves and which it serves by laying, both of shape (places, n).
    """
    serves = np.array([above_table(workspace, pinches, place) for place in places])
    served = serves.any(axis=0)  # who serves no placement needs not be looked at closely, unless nobody serves any
    asked = ~serves & (served if served.any() else True)
    lays = np.array([_lays(workspace, obj, pinches, place, asked[i]) for i, place in enumerate(places)])
    ways = (serves | lays).sum(axis=0) + 0.5 * serves.sum(axis=0)
    order = rng.permutation(len(pinches.widths))
    order = order[np.argsort(-ways[order], kind="stable")]
    order = order[ways[order] > 0][:SIEVED]
    return pinches.at(order), serves[:, order], lays[:, order]


def _lays(
    workspace: Workspace, obj: str, pinches: Pinches, place: Placement, asked: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Whether each of the pinches asked about can let the object fall to its goal, as far as the table says, (n,)."""
    able = np.zeros(len(pinches), bool)
    for let_go in letting_go(workspace, obj, place):
        rest = np.flatnonzero(asked & ~able)
        able[rest] = above_table(workspace, pinches.at(rest), Placement(let_go, place.on))
    return able


def _fall_cost(
    workspace: Workspace, obj: str, pinches: Pinches, place: Placement, asked: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """What it costs each of the pinches asked about to let the object fall to its goal, HINDERED where it cannot, (n,).

    The hand must be clear of what carries the object, and of the object on its way straight down.
    """
    cost = np.full(len(pinches), HINDERED)
    for let_go in letting_go(workspace, obj, place):
        rest = np.flatnonzero(asked & (cost >= HINDERED))
        rest = rest[above_table(workspace, pinches.at(rest), Placement(let_go, place.on))]
        straight = falls_straight(let_go, place.pose)
        if straight:
            rest = rest[clear_of_falling(workspace, obj, pinches.at(rest), let_go)]
        rest = rest[support_cost(workspace, pinches.at(rest), obj, place, let_go) < HINDERED]
        cost[rest] = LAID + (FALLING * (let_go.xyz[2] - place.pose.xyz[2]) if straight else 0.0)
    return cost


def _spread(pinches: Pinches, costs: NDArray[np.float64]) -> list[int]:
    """Indices, best first, the best of every neighbourhood of similar grasps before the second best of any."""
    T = pinches.T_object_tool
    cells = np.round(np.concatenate([T[:, :3, 3] / 0.012, T[:, :3, 2] / 0.4, T[:, :3, 0] / 0.4], axis=1))
    seen: dict[bytes, int] = {}
    repeats = np.zeros(len(costs), int)
    for index in np.argsort(costs, kind="stable").tolist():
        key = cells[index].tobytes()
        repeats[index] = seen.get(key, 0)
        seen[key] = repeats[index] + 1
    order: list[int] = np.lexsort((costs, repeats > 0, costs >= HINDERED)).tolist()
    return order


def _reachable_first(
    context: Context,
    workspace: Workspace,
    pinches: Pinches,
    costs: NDArray[np.float64],
    obj: str,
    places: list[Placement],
) -> Iterator[Grasp | None]:
    """Yield grasps that the arm can reach at every placement as they come; afterwards those of one only.

    Those in which the object would turn come between them, see `second_best`.
    """
    partly: list[Grasp] = []
    loose: list[tuple[float, Grasp]] = []
    for index in _spread(pinches, costs)[:LIMIT]:
        grasp = closed(workspace, obj, pinches.T_object_tool[index], float(pinches.widths[index]))
        if grasp is None:
            pass
        elif costs[index] >= HINDERED or not all(_reached(context, workspace, obj, place, grasp) for place in places):
            partly.append(grasp)
        elif (angle := max(turning(workspace, obj, grasp, place.pose) for place in places)) > FIRM:
            loose.append((angle, grasp))
        else:
            yield grasp
            continue
        yield None
    yield from second_best(workspace, obj, places[0], loose, partly)


def _reached(context: Context, workspace: Workspace, obj: str, place: Placement, grasp: Grasp) -> bool:
    """Whether the arm can reach an object by a grasp as it stands at a placement, or above it."""
    poses = [place.pose, *letting_go(workspace, obj, place)]
    tools = (pose.matrix @ grasp.T_object_tool.matrix for pose in poses)
    around = standing_around(workspace, obj, place)
    carriers = Scene({name: around[name].pose.matrix for name in beneath(place, around)})
    over = (T for T in tools if not hand_hits(workspace, T, grasp.width, carriers))
    return any(next(inverse(workspace.world.robot, T, context.rng, count=1), None) is not None for T in islice(over, 3))
