"""Regrasps over an edge of the table: where an object hangs over it, a hand takes hold from beside, or from below.

What has to be turned over is held from above before and after, and so from opposite sides of it: no face that it might
rest on amid the table leaves room for both hands. Over an edge the second one comes from where the table is not.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.affordances.neighbours import upon_carriers
from tamp.streams.affordances.slide_path import LEAST_OVERHANG, OVERHANGS, STEADY
from tamp.streams.affordances.stable_poses import amid, resting, righted, rolls_down, stands, turned
from tamp.streams.affordances.support import inside_support
from tamp.streams.cache import recalled, stepwise
from tamp.streams.collisions import overlap
from tamp.streams.context import Context, Detached
from tamp.streams.grasping.sampler import serving_at_a_glance
from tamp.streams.motion.inverse_kinematics import reaches
from tamp.streams.placing.sampler import RELEASE_HEIGHT
from tamp.streams.releasing.tilted_release import lays
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace, standing
from tamp.task import Pose
from tamp.task.mesh.parts import Part, convex_hull

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DRAWN = 256  # places, of which ...
PLACES = 24  # ... those nearest to the robot are looked at: over edges there the hand gets farther out, and down
MANY = 20  # of a few hands seem to serve a place that is worth the time before an object is laid down
TRIED = 6  # places of those that many hands seem to serve, and of the others; those first that most seem to
GRASPS = 12  # looked at for a place and either end
FIRM = 0.004  # what is left of its base on the table carries an object so far around its centre of mass [m]

Grasps = Callable[..., Iterable[Grasp]]
Regrasp = tuple[Grasp, Placement, Grasp]


@dataclass(frozen=True, repr=False)
class _By:
    """Whose grasps they are, as a part of a key; the generator derived from it is the same for all."""

    grasps: Grasps

    def __repr__(self) -> str:
        return "grasps"


def regrasps_over_edges(
    context: Context, obj: str, start: Placement, goal: Placement, grasps: Grasps, *, many: bool
) -> Iterator[Regrasp]:
    """Yield (grasp that takes an object up, placement over an edge, grasp that puts it to its goal).

    Each is free of collision with the table, the robot and the object, as if nothing else stood there. The placement is
    clear of what the plan has standing there and of every goal.

    Args:
        context: as of every sampler.
        obj: the object.
        start: where it is.
        goal: where it shall be.
        grasps: of the object that serve some placements.
        many: whether only places are tried that many hands seem to serve, or only the others.
    """
    workspace: Workspace = context.scene
    others = {name: place for name, place in standing(context.bound).items() if name != obj}
    kept = [*others.items(), *((name, goal) for name, goal in workspace.goals.items() if name != obj)]
    inputs, reads = (obj, start, goal, _By(grasps), many), upon_carriers(workspace, obj, start, goal)
    draw = partial(_drawn, obj=obj, start=start, goal=goal, grasps=grasps, many=many)
    for one, place, other in recalled(context, "regrasps over edges", inputs, reads, draw):
        if not any(overlap(workspace, obj, place, name, there) for name, there in kept):
            yield one, place, other


def _drawn(
    context: Detached, obj: str, start: Placement, goal: Placement, grasps: Grasps, many: bool
) -> Iterator[Regrasp | None]:
    """The same whatever else stands there; None after each place or grasp that is looked at."""
    looked = partial(_looked_at, obj=obj, start=start, goal=goal)
    seen = list[tuple[int, Placement]]()
    for glance in stepwise(context, "places over edges", (obj, start, goal), context.scene, looked):
        seen += [] if glance is None else [glance]
        yield None
    seen.sort(key=lambda pair: -pair[0])
    found = False
    for place in [place for hands, place in seen if hands and (hands >= MANY) == many][:TRIED]:
        second = yield from _serving(context, obj, place, goal, grasps)
        first = None if second is None else (yield from _serving(context, obj, start, place, grasps))
        if first is not None and second is not None:
            found = True
            yield first, place, second
    if not found and not many:  # the others are asked last
        context.fail(f"no place for {obj} over an edge of the table that two grasps reach")


def _looked_at(context: Detached, obj: str, start: Placement, goal: Placement) -> Iterator[tuple[int, Placement]]:
    """Places over the edges, the nearest to the robot, and how many of a few hands seem to serve each, at both ends."""
    for place in _places(context, obj, _faces(context.scene, obj, start)):
        hands = serving_at_a_glance(context, obj, (place, goal))
        yield (min(hands, serving_at_a_glance(context, obj, (start, place))) if hands else 0), place


def _serving(
    context: Detached, obj: str, at: Placement, to: Placement, grasps: Grasps
) -> Generator[None, None, Grasp | None]:
    """A grasp that takes an object up at one placement, and puts or lays it down at another, if one is found."""
    for grasp in islice(grasps(context, obj, at, to), GRASPS):
        alone = Detached.of(context)
        if reaches(alone, obj, at, grasp) and (reaches(alone, obj, to, grasp) or lays(alone, obj, to, grasp)):
            return grasp
        yield None
    return None


def _faces(workspace: Workspace, obj: str, start: Placement) -> list[Array]:
    """The orientations (3, 3) in which an object may be put down over an edge.

    A hand from beside can do so where there is no table under it, so that no face is left out for lack of room amid the
    table. However unlikely, the object may lie as it lies now.
    """
    now = [start.pose.matrix[:3, :3]] if start.on == (TABLE,) else []
    return [*resting(workspace, obj), *now]


def _places(context: Detached, obj: str, faces: list[Array]) -> list[Placement]:
    """Places over the edges, the nearest to the robot."""
    base = np.array(context.scene.world.robot.spec.T_world_base.xyz)[:2]
    drawn = [_over_edge(context, obj, faces[int(context.rng.integers(len(faces)))]) for _ in range(DRAWN) if faces]
    found = [place for place in drawn if place is not None]
    found.sort(key=lambda place: float(np.linalg.norm(np.array(place.pose.xyz[:2]) - base)))
    return found[:PLACES]


def _over_edge(context: Detached, obj: str, R: Array) -> Placement | None:
    """A random place where an object, turned by R (3, 3) and any heading, hangs over an edge; None where it would fall.

    Its centre of mass stays inside the edge, and beside the robot's base.
    """
    workspace, rng = context.scene, context.rng
    table, spec = workspace.task.table, workspace.world.robot.spec
    base = np.array(spec.T_world_base.xyz[:2])
    flat = amid(workspace, obj, turned(R, rng.uniform(-np.pi, np.pi)))
    T, axis, sign = flat.pose.matrix, int(rng.integers(2)), float(rng.choice((-1.0, 1.0)))
    center = T[:3, :3] @ workspace.world.geometries[obj].center_of_mass
    farthest = float((workspace.points(obj) @ T[axis, :3] * sign).max()) - sign * center[axis] - STEADY
    hanging = float(rng.choice(OVERHANGS)) * farthest
    if hanging < LEAST_OVERHANG:
        return None
    middle, half = np.array(table.center), np.array(table.size) / 2
    xy = middle + rng.uniform(-1.0, 1.0, 2) * half
    xy[axis] = middle[axis] + sign * (half[axis] - STEADY - (farthest - hanging))
    T[:3, 3] = *(xy - center[:2]), T[2, 3] + RELEASE_HEIGHT
    place = Placement(Pose.from_matrix(T), (TABLE,))
    lower, upper = workspace.bounds(obj, place.pose)
    beside = float(np.linalg.norm(np.clip(base, lower[:2], upper[:2]) - base)) > spec.base_radius
    firm = beside and inside_support(workspace, obj, place, {}) > FIRM
    return place if firm and _stays(workspace, obj, place, axis, sign) else None


def _stays(workspace: Workspace, obj: str, place: Placement, axis: int, sign: float) -> bool:
    """Whether what is over the table carries an object that hangs over one of its edges as the whole would on a plane.

    The handle of a tool does not keep it from rolling where the head hangs over.
    """
    geometry, R = workspace.world.geometries[obj], place.pose.matrix[:3, :3]
    edge = sign * workspace.task.table.center[axis] + workspace.task.table.size[axis] / 2
    corners = [_within(part, sign * place.pose.matrix[axis], edge) for part in geometry.parts]
    over = replace(geometry, parts=(convex_hull(np.concatenate(corners)),))
    return stands(over, R) and righted(over, R) is R and not rolls_down(over, R)


def _within(part: Part, along: Array, limit: float) -> Array:
    """Corners (n, 3) of what of a convex part is not beyond a limit; `along` is how far a point is (x, y, z, 1)."""
    beyond = part.vertices @ along[:3] + along[3] - limit
    ends = np.concatenate([part.faces[:, [0, 1]], part.faces[:, [1, 2]], part.faces[:, [2, 0]]])
    inner, outer = ends[(beyond[ends[:, 0]] <= 0.0) & (beyond[ends[:, 1]] > 0.0)].T
    share = beyond[inner] / (beyond[inner] - beyond[outer])
    cut = part.vertices[inner] + share[:, None] * (part.vertices[outer] - part.vertices[inner])
    return np.concatenate([part.vertices[beyond <= 0.0], cut])
