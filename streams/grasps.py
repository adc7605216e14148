"""Antipodal grasps of any mesh, best first.

Candidates pinch the object between two opposite contacts from many directions and at several depths. They are ranked
by what makes a grasp hold and reach: pad area in contact, leverage about the centre of mass, contact angle, upright
approach, and whether the arm reaches and the hand is clear of table and neighbours, both where the object stands and
where it shall stand.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.clearance import HINDERED, clear_of_object, neighbour_cost
from tamp.streams.closing import closed
from tamp.streams.enclosed import company, enclosed, roomy_pinches
from tamp.streams.holding import FIRM, looseness, second_best
from tamp.streams.pinches import SURFACE, Pinches, intrinsic_cost
from tamp.streams.recall import recalled
from tamp.streams.serving import over_table, placement_cost
from tamp.streams.topples import to_be_pushed
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Context, Workspace

if TYPE_CHECKING:
    from numpy.typing import NDArray

GLANCE = 150  # points on the surface that a first round of sampling looks at
ROUNDS = 8  # after it, of SURFACE points, where few grasps are clear at every placement
FEW = 4  # rounds that are enough where the object lies in something, or where no such grasp has come
ENOUGH = 40  # clear grasps after which no further round is needed
AMONG = 12  # the same where the object lies in something: those few are known to have room
PROMISING = 250  # of those, for which neighbours count
LIMIT = 160  # grasps offered for one object


def sample_grasp(context: Context, obj: str) -> Iterator[Grasp]:
    """Yield grasps of obj, best first: those that serve start and goal, then those that serve one of them.

    They are ranked among the neighbours as they stood when they were first asked for.
    """
    if to_be_pushed(context.scene, obj, context.scene.start[obj]):
        context.fail(f"no hand can grasp {obj} as it stands before it is pushed to where one can")
        return
    places = list(dict.fromkeys(context.scene.placements_of(obj)))
    key = ("grasps", obj, *places, *company(context.scene, obj), str(context.rng.bit_generator.state))
    yield from recalled(context, key, lambda first: grasps_at(first, obj, places))


def grasps_at(context: Context, obj: str, places: list[Placement]) -> Iterator[Grasp | None]:
    """Yield grasps of obj, best first: those that serve all placements, then those that serve some of them.

    None stands for work done without a grasp, so that whoever waits for one can look at the clock.
    """
    workspace: Workspace = context.scene
    found, costs = yield from _candidates(context, workspace, obj, places)
    if len(costs):
        yield from _firm_first(workspace, found, costs, obj, places)


def _candidates(
    context: Context, workspace: Workspace, obj: str, places: list[Placement]
) -> Generator[None, None, tuple[Pinches, NDArray[np.float64]]]:
    """Pinches and what speaks against each; sampled anew until enough of them are clear at every placement."""
    rounds: list[Pinches] = []
    costs: list[NDArray[np.float64]] = []
    enough, crowded = 0, enclosed(workspace, obj, workspace.start[obj])
    for points in (GLANCE, *(SURFACE for _ in range(ROUNDS))):
        pinches, cost, met = _round(context, workspace, obj, places, points)
        rounds.append(pinches)
        costs.append(cost + met)
        # Among neighbours one cannot choose from too many, so a glance is enough where they are not met.
        enough += int(((cost < HINDERED) & ((met == 0) | (points > GLANCE))).sum())
        if enough >= (AMONG if crowded else ENOUGH) or (len(rounds) == FEW and (crowded or not enough)):
            break
        yield None
    return Pinches.joined(rounds), np.concatenate(costs)


def _round(
    context: Context, workspace: Workspace, obj: str, places: list[Placement], points: int
) -> tuple[Pinches, NDArray[np.float64], NDArray[np.float64]]:
    """One round of sampling: the promising pinches, what they cost, and what the neighbours that they meet cost."""
    pinches = roomy_pinches(workspace, obj, places, context.rng, points)
    if not len(pinches):
        context.fail(f"{obj} has no two opposite surfaces within the gripper's stroke and with room for a hand")
        return pinches, np.empty(0), np.empty(0)
    pinches, serves, lays = over_table(workspace, obj, pinches, places, context.rng)
    clear = clear_of_object(workspace, obj, pinches)
    pinches, serves, lays = pinches.at(clear), serves[:, clear], lays[:, clear]
    if not len(pinches):
        context.fail(f"the hand would hit the table or {obj} itself in every grasp of {obj}")
        return pinches, np.empty(0), np.empty(0)
    cost = intrinsic_cost(workspace, obj, pinches)
    for place, usable, laid in zip(places, serves, lays, strict=True):
        cost += placement_cost(workspace, obj, pinches, place, usable, laid)
    promising = np.array(_spread(pinches, cost)[:PROMISING])
    pinches, cost = pinches.at(promising), cost[promising]
    met = np.sum([neighbour_cost(workspace, pinches, obj, place) for place in places], axis=0)
    return pinches, cost, met


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
    workspace: Workspace, pinches: Pinches, costs: NDArray[np.float64], obj: str, places: list[Placement]
) -> Iterator[Grasp | None]:
    """Yield grasps that serve every placement as they come; afterwards those that serve one only.

    Those in which the object would move come between them, see `second_best`.
    """
    partly: list[Grasp] = []
    loose: list[tuple[float, Grasp]] = []
    for index in _spread(pinches, costs)[:LIMIT]:
        width, clearance = float(pinches.widths[index]), float(pinches.clearances[index])
        grasp = closed(workspace, obj, pinches.T_object_tool[index], width, clearance)
        if grasp is None:
            pass
        elif costs[index] >= HINDERED:
            partly.append(grasp)
        elif (angle := looseness(workspace, obj, grasp, *(place.pose for place in places))) > FIRM:
            loose.append((angle, grasp))
        else:
            yield grasp
            continue
        yield None
    yield from second_best(workspace, obj, places[0], loose, partly)
