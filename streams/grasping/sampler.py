"""Antipodal grasps of any mesh, best first.

Candidates pinch the object between two opposite contacts from many directions and at several depths. They are ranked
by what makes a grasp hold and reach: pad area in contact, leverage about the centre of mass, contact angle, upright
approach, and whether the arm reaches and the hand is clear of table and neighbours, both where the object stands and
where it shall stand.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from functools import partial
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.neighbours import enclosed, upon_carriers, within
from tamp.streams.affordances.stable_poses import amid, resting
from tamp.streams.affordances.topple_path import to_be_pushed
from tamp.streams.cache import Draw, recalled, stepwise
from tamp.streams.context import Context, Detached
from tamp.streams.grasping.container import roomy_pinches
from tamp.streams.grasping.hand_clearance import HINDERED, neighbour_cost
from tamp.streams.grasping.ranking import over_table, placement_cost, untwisted
from tamp.streams.hand.candidates import SURFACE, Pinches, intrinsic_cost
from tamp.streams.hand.clearance import clear_of_object, hand_above_table, reach_of_hand
from tamp.streams.hand.finger_closing import closed
from tamp.streams.hand.firmness import second_best, unsteadiness
from tamp.streams.hand.stability import FIRM, askew, straightened, too_heavy
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Workspace

if TYPE_CHECKING:
    from numpy.typing import NDArray

GLANCE = 150  # points on the surface that a first round of sampling looks at
ROUNDS = 8  # after it, of SURFACE points, where few grasps are clear at every placement
SURFACES = (GLANCE, *[SURFACE] * ROUNDS)
FEW = 4  # rounds that are enough where the object lies in something, or where no such grasp has come
ENOUGH = 40  # clear grasps after which no further round is needed
AMONG = 12  # the same where the object lies in something: those few are known to have room
PROMISING = 250  # of those, for which neighbours count
LIMIT = 160  # grasps offered for one object

Ranked = tuple[Pinches, "NDArray[np.float64]", "NDArray[np.bool_]"]
"""Pinches, what speaks against each, and which take the object up at the first of its placements; all of one length."""


def sample_grasp(context: Context, obj: str) -> Iterator[Grasp]:
    """Yield grasps of obj, best first: those that serve start and goal, then those that serve one of them."""
    if to_be_pushed(context.scene, obj, context.scene.start[obj]):
        context.fail(f"no hand can grasp {obj} as it stands before it is pushed to where one can")
        return
    yield from grasps(context, obj, tuple(dict.fromkeys(context.scene.placements_of(obj))))


def grasps(context: Context, obj: str, places: tuple[Placement, ...]) -> Iterator[Grasp]:
    """Yield grasps of obj, best first: those that serve all placements, then those that serve some of them.

    They are ranked among what stands within a hand's reach of the object at each of them.
    """
    yield from recalled(context, "grasps", (obj, places), *_ranked(context.scene, obj, places))


def serving_at_a_glance(context: Detached, obj: str, places: tuple[Placement, ...]) -> int:
    """How many of a few grasps would serve all placements, were nothing there but what carries the object."""
    _, cost, _ = next(_pinches(context, obj, places))
    return int((cost < HINDERED).sum())


def grasps_in_steps(context: Context, obj: str, places: tuple[Placement, ...]) -> Iterator[Grasp | None]:
    """The same with None for work done without a grasp, so that whoever waits for one can give up."""
    yield from stepwise(context, "grasps", (obj, places), *_ranked(context.scene, obj, places))


def _ranked(workspace: Workspace, obj: str, places: tuple[Placement, ...]) -> tuple[Workspace, Draw[Grasp]]:
    """What the ranking of grasps depends on, and what draws it."""
    near = within(workspace, obj, reach_of_hand(workspace), *places, workspace.start[obj])
    return near, partial(_drawn, obj=obj, places=places)


def _drawn(context: Context, obj: str, places: tuple[Placement, ...]) -> Iterator[Grasp | None]:
    workspace: Workspace = context.scene
    if (heavy := too_heavy(workspace, obj)) is not None:
        context.fail(heavy)
        return
    found, costs, takes = yield from _candidates(context, workspace, obj, places)
    if len(costs):
        yield from _firm_first(workspace, found, costs, takes, obj, places)


def _candidates(
    context: Context, workspace: Workspace, obj: str, places: tuple[Placement, ...]
) -> Generator[None, None, Ranked]:
    """Pinches and what speaks against each; sampled anew until enough of them are clear at every placement.

    Where the object lies in something, its neighbours decide which pinches are drawn; else only how they are ranked,
    and the same are ranked anew where others stand there.
    """
    rounds: list[Ranked] = []
    enough, crowded = 0, enclosed(workspace, obj, workspace.start[obj])
    for points, (pinches, cost, takes) in zip(SURFACES, _pinches(context, obj, places), strict=False):
        met = np.sum([neighbour_cost(workspace, pinches, obj, place) for place in places], axis=0)
        rounds.append((pinches, cost + met, takes))
        # Among neighbours one cannot choose from too many, so a glance is enough where they are not met.
        enough += int(((cost < HINDERED) & ((met == 0) | (points > GLANCE))).sum())
        if enough >= (AMONG if crowded else ENOUGH) or (len(rounds) == FEW and (crowded or not enough)):
            break
        yield None
    found, costs, taking = zip(*rounds, strict=True)
    return Pinches.joined(found), np.concatenate(costs), np.concatenate(taking)


def _pinches(context: Context, obj: str, places: tuple[Placement, ...]) -> Iterator[Ranked]:
    """The rounds of `_rounds`, each drawn once for all who ask."""
    workspace: Workspace = context.scene
    lying = any(enclosed(workspace, obj, place) for place in places)
    reads = workspace if lying else upon_carriers(workspace, obj, *places, workspace.start[obj])
    yield from recalled(context, "pinches", (obj, places), reads, partial(_rounds, obj=obj, places=places))


def _rounds(context: Context, obj: str, places: tuple[Placement, ...]) -> Iterator[Ranked]:
    """Yield the promising pinches of each round of sampling, ranked as if no neighbour were there."""
    for turn, points in enumerate(SURFACES):
        yield _round(context, obj, places, roomy_pinches(context, obj, places, points, turn))


def _round(context: Context, obj: str, places: tuple[Placement, ...], pinches: Pinches) -> Ranked:
    workspace: Workspace = context.scene
    if not len(pinches):
        context.fail(f"{obj} has no two opposite surfaces within the gripper's stroke and with room for a hand")
        return pinches, np.empty(0), np.empty(0, bool)
    pinches = untwisted(workspace, pinches, places)
    pinches, serves, lays = over_table(workspace, obj, pinches, places, context.rng)
    clear = clear_of_object(workspace, obj, pinches)
    pinches, serves, lays = pinches.at(clear), serves[:, clear], lays[:, clear]
    if not len(pinches):
        context.fail(f"the hand would hit the table or {obj} itself in every grasp of {obj}")
        return pinches, np.empty(0), np.empty(0, bool)
    each = [placement_cost(workspace, obj, pinches, *at) for at in zip(places, serves, lays, strict=True)]
    cost = intrinsic_cost(workspace, obj, pinches) + np.sum(each, axis=0)
    promising = np.array(_spread(pinches, cost)[:PROMISING])
    return pinches.at(promising), cost[promising], each[0][promising] < HINDERED


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


def _firm_first(
    workspace: Workspace,
    pinches: Pinches,
    costs: NDArray[np.float64],
    takes: NDArray[np.bool_],
    obj: str,
    places: tuple[Placement, ...],
) -> Iterator[Grasp | None]:
    """Yield grasps that serve every placement as they come; afterwards those that serve one only.

    Of these every second one takes the object up at the first placement, such ones first that can put it aside then.
    Those in which the object would move come between them, see `second_best`.
    """
    taking, bringing = list[Grasp](), list[Grasp]()
    loose: list[tuple[float, Grasp]] = []
    for index in _spread(pinches, costs)[:LIMIT]:
        width, clearance = float(pinches.widths[index]), float(pinches.clearances[index])
        grasp = closed(workspace, obj, pinches.T_object_tool[index], width, clearance)
        if grasp is not None:
            grasp = straightened(workspace, obj, grasp) or grasp  # turned, it may hold nothing any more
        if grasp is None or askew(workspace, obj, grasp):
            pass
        elif costs[index] >= HINDERED:
            (taking if takes[index] else bringing).append(grasp)
        elif (angle := unsteadiness(workspace, obj, grasp, *(place.pose for place in places))) > FIRM:
            loose.append((angle, grasp))
        else:
            yield grasp
            continue
        yield None
    taking.sort(key=lambda grasp: not _puts_aside(workspace, obj, grasp))
    partly = [grasp for pair in zip_longest(taking, bringing) for grasp in pair if grasp is not None]
    yield from second_best(workspace, obj, places[0], loose, partly)


def _puts_aside(workspace: Workspace, obj: str, grasp: Grasp) -> bool:
    """Whether there is a face on which a hand can put the object on the table."""
    midst = (amid(workspace, obj, R).pose for R in resting(workspace, obj))
    return any(hand_above_table(workspace, pose, grasp) for pose in midst)
