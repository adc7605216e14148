"""Does anything touch anything while the arm follows a trajectory? Looked at so often that nothing slips between."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.moving import advanced, centers_of, gaps_to_box, meeting, relative, ways
from tamp.checking.geometry.solids import Solid, crossed, parted
from tamp.checking.robot.cubic import derivatives, interpolate

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from tamp.task.plan import Trajectory

    Array = NDArray[np.float64]

FIRST_STEP = 0.05
"""Joint motion [rad] between the samples of the first, coarse grid."""

FINEST = 5e-4
"""What moves by no more than this is not looked at in between [m]."""

BENT = 0.1
"""Share of that distance by which a point may leave the straight line between two looks."""

FAR = 0.02
"""Distance [m] of a body from the box round another one from which on it serves as the distance of the two."""


@dataclass(frozen=True, eq=False)
class Mover:
    """A body with its pose T_world_body at each sample, shape (n, 4, 4); one that stands still has n = 1.

    The poses are in C order and not read-only, as compiled loops want them. `astray` is a body where it is in truth,
    which is not where the plan says.
    """

    solid: Solid
    T: Array
    astray: bool = False

    @cached_property
    def center(self) -> Array:
        """Centre of the solid's sphere in the world at each sample, shape (n, 3)."""
        return centers_of(self.T, self.solid.center)


@dataclass(frozen=True)
class Touch:
    """Two bodies closer than they may be: at which sample, and how deep they interpenetrate [m]."""

    sample: int
    bodies: tuple[str, str]
    depth: float


@dataclass(frozen=True, eq=False)
class Looks:
    """When a motion is looked at, and what is where then.

    Attributes:
        times: shape (n,) [s].
        bodies: all that moves, in the order in which it was asked for.
        swing: how far any point leaves the straight line between two looks, shape (n - 1,) [m].
    """

    times: Array
    bodies: Sequence[Mover]
    swing: Array


def looks(
    trajectory: Trajectory, movers: Callable[[Array], Sequence[Mover]], step: float, reach: float, most: int
) -> Looks | None:
    """Looks so dense that between two of them no point of any mover moves by more than `step` [m], nor bends.

    Args:
        trajectory: a well-formed trajectory.
        movers: the bodies for configurations of shape (n, joints).
        step: the bound [m].
        reach: no point of a mover is farther than this from any joint of the arm [m].
        most: largest number of looks.

    Returns:
        None where more looks are needed than that.
    """
    # The speed within a span is at most that of its two ends and one and a half of its mean speed.
    speed = np.abs(trajectory.velocities).max(axis=1)
    mean = np.abs(np.diff(trajectory.positions, axis=0)).max(axis=1)
    way = 1.5 * mean + np.maximum(speed[:-1], speed[1:]) * np.diff(trajectory.times)
    counts = np.maximum(np.ceil(way / FIRST_STEP), 1)
    times = trajectory.times
    while counts.sum() < most:
        times = _split(times, counts)
        swing = _swing(trajectory, times, reach)
        bodies = movers(interpolate(trajectory, times))
        moved = np.max([travelled(body.solid, body.T) for body in bodies], axis=0)
        over = np.maximum(1.1 * moved / step, np.sqrt(swing / (BENT * step)))  # the swing falls with the square
        counts = np.where((moved + swing > step) | (swing > BENT * step), np.maximum(np.ceil(over), 2), 1)
        if (counts == 1).all():
            return Looks(times, bodies, swing)
    return None


def _swing(trajectory: Trajectory, times: Array, reach: float) -> Array:
    """How far any point may leave the straight line between two looks, within one span of the cubic each [m].

    A curve leaves its chord by at most its largest acceleration times the time squared, over eight. A point within
    `reach` of all joints has an acceleration of at most reach * (sum |q''| + (sum |q'|)^2): every joint adds its own,
    and every pair of joints turns what the other one adds.
    """
    dt = np.diff(times)
    turning, speeding = derivatives(trajectory, times)
    fastest = turning.max(axis=0) + speeding.max(axis=0) * dt[:, None] / 2
    acceleration = speeding.max(axis=0).sum(axis=1) + fastest.sum(axis=1) ** 2
    swing: Array = max(reach, 1.0) * acceleration * dt**2 / 8
    return swing


def _split(times: Array, counts: Array) -> Array:
    """Each span between two times divided into so many equal ones."""
    whole = np.maximum(counts, 1).astype(np.int64)
    span = np.repeat(np.diff(times) / whole, whole)
    first = np.repeat(times[:-1], whole)
    index = np.arange(whole.sum()) - np.repeat(np.cumsum(whole) - whole, whole)
    return np.append(first + index * span, times[-1])


def travelled(solid: Solid, T: Array) -> Array:
    """Bound on the distance any point of a solid moves from each pose to the next, shape (n - 1,) [m]."""
    return ways(T, solid.center, solid.radius)


def passed(moving: Sequence[Mover], still: Sequence[Mover]) -> list[Mover]:
    """Of bodies that stand still those whose sphere meets the box round some sphere that moves, in order."""
    radii, still_radii = (np.array([body.solid.radius for body in bodies]) for bodies in (moving, still))
    lower = np.array([body.center.min(axis=0) for body in moving]) - radii[:, None]
    upper = np.array([body.center.max(axis=0) for body in moving]) + radii[:, None]
    centers = np.array([body.center[0] for body in still]).reshape(-1, 1, 3)
    beyond = np.maximum(np.maximum(lower - centers, centers - upper), 0.0)
    near = ((beyond**2).sum(axis=2) <= still_radii[:, None] ** 2).any(axis=1)
    return [body for body, meets in zip(still, near.tolist(), strict=True) if meets]


def touches(pairs: Iterable[tuple[Mover, Mover, float]], swing: Array | None = None) -> list[Touch]:
    """For each pair of bodies (a, b, allowed depth) the first sample where they are deeper than allowed, if any.

    `swing`, shape (samples - 1,), is how far any point leaves the straight line between two samples [m].
    """
    near = _near(list(pairs))
    found = [touch for a, b, allowed in near if (touch := _first_touch(a, b, allowed, swing)) is not None]
    return sorted(found, key=lambda touch: (touch.sample, touch.bodies))


def slid(a: Mover, b: Mover, deep: float) -> float:
    """How far b moves, in all, as seen from a, while it is deeper in it than that from one sample to the next [m]."""
    pressed = pressed_looks(a, b, deep)
    return float(travelled(b.solid, relative(a.T, b.T))[pressed[1:] & pressed[:-1]].sum())


def pressed_looks(a: Mover, b: Mover, deep: float) -> NDArray[np.bool_]:
    """At which samples b is deeper in a than that [m], shape (n,)."""
    T_a_b = relative(a.T, b.T)
    near = gaps_to_box(centers_of(T_a_b, b.solid.center), b.solid.radius, a.solid.lower, a.solid.upper) <= 0.0
    pressed = np.zeros(len(T_a_b), bool)
    for k in np.flatnonzero(near):
        pressed[k] = parted(a.solid, b.solid, T_a_b[k], deep)[0] < -deep
    return pressed


def _near(pairs: Sequence[tuple[Mover, Mover, float]]) -> Iterator[tuple[Mover, Mover, float]]:
    """The pairs whose spheres meet at some sample, in order."""
    bodies = list({id(body): body for a, b, _ in pairs for body in (a, b)}.values())
    place = {id(body): index for index, body in enumerate(bodies)}
    samples = max((len(body.T) for body in bodies), default=1)
    centers = np.empty((len(bodies), samples, 3))
    for index, body in enumerate(bodies):
        centers[index] = body.center
    radii = np.array([body.solid.radius for body in bodies])
    first, second = (np.array([place[id(pair[side])] for pair in pairs], np.int64) for side in (0, 1))
    yield from (pairs[index] for index in np.flatnonzero(meeting(centers, radii, first, second)).tolist())


def _first_touch(a: Mover, b: Mover, allowed: float, swing: Array | None) -> Touch | None:
    """Conservative advancement over samples (Mirtich 1996): a pair apart by d cannot touch before it has moved by d.

    The motion is that of b in the frame of a, so bodies that travel together cost one look. A look at their shapes is
    taken only where neither the box round a nor the plane that parted them at the last look keeps them apart.
    """
    bound = min(allowed, (a.solid.thinnest + b.solid.thinnest) / 4)
    T_a_b = relative(a.T, b.T)
    centers = centers_of(T_a_b, b.solid.center)
    gaps = gaps_to_box(centers, b.solid.radius, a.solid.lower, a.solid.upper)
    if gaps.min() > 0.0:
        return None
    steps = travelled(b.solid, T_a_b)
    path = np.concatenate([[0.0], np.cumsum(steps if swing is None else steps + swing)])
    corners = (a.solid.hull.corners, b.solid.hull.corners)
    aside = centers[0] - a.solid.center
    normal, k = aside / max(float(np.linalg.norm(aside)), 1e-9), 0
    seen: dict[int, float] = {}  # how far they are apart at the last look
    while (k := advanced(k, T_a_b, gaps, path, bound, FAR, normal, corners)) < len(T_a_b):
        room, normal = parted(a.solid, b.solid, T_a_b[k], bound)
        depth = -room if _too_deep(a.solid, b.solid, T_a_b[k], room, allowed) else 0.0
        if k and not depth and bound < path[k] - path[k - 1] - room:
            before = seen[k - 1] if k - 1 in seen else parted(a.solid, b.solid, T_a_b[k - 1], bound)[0]
            way = path[k] - path[k - 1]
            depth = _depth_between(a.solid, b.solid, T_a_b[k - 1 : k + 1], way, (before, room), allowed)
        if depth:
            return Touch(k, (a.solid.name, b.solid.name), depth)
        seen = {k: room}
        k = max(k + 1, int(np.searchsorted(path, path[k] + room + bound, side="right")))
    return None


def _too_deep(a: Solid, b: Solid, T_a_b: Array, room: float, allowed: float) -> bool:
    """Whether two solids that are apart by `room` are deeper in each other than `allowed` [m], or thin and crossed."""
    return -room > min(allowed, (a.thinnest + b.thinnest) / 4) and (-room > allowed or crossed(a, b, T_a_b))


def _depth_between(a: Solid, b: Solid, T: Array, way: float, apart: tuple[float, float], allowed: float) -> float:
    """How deep b is in a somewhere between two looks T, shape (2, 4, 4), in the frame of a [m]; 0 where not too deep.

    Thin bodies may pass through each other from one look to the next. Where they are `apart` by r at one and by s at
    the other, and no point moves by more than `way` in between, they are nowhere deeper than (way - r - s) / 2; where
    that is too much the way is halved.
    """
    bound = min(allowed, (a.thinnest + b.thinnest) / 4)
    if way - sum(apart) <= 2 * bound or way < FINEST:
        return 0.0
    middle = _halfway(T)
    between, _ = parted(a, b, middle, bound)
    if _too_deep(a, b, middle, between, allowed):
        return -between
    first = _depth_between(a, b, np.stack([T[0], middle]), way / 2, (apart[0], between), allowed)
    return first or _depth_between(a, b, np.stack([middle, T[1]]), way / 2, (between, apart[1]), allowed)


def _halfway(T: Array) -> Array:
    """The pose half-way between two that are near each other, shape (2, 4, 4): the nearest one to their mean."""
    mean: Array = T.mean(axis=0)
    U, _, V = np.linalg.svd(mean[:3, :3])
    mean[:3, :3] = U @ V
    return mean


def standing(solids: Mapping[str, Solid], poses: Mapping[str, Array], *, astray: bool = False) -> list[Mover]:
    """Bodies that stand still, by name in order; `astray` where that is not where the plan says."""
    return [Mover(solids[name], np.array(poses[name][None]), astray) for name in sorted(poses)]
