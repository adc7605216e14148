"""Does anything touch anything while the arm follows a trajectory? Every sample counts, few need to be looked at."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.distances import clearance
from tamp.checking.limits import interpolate
from tamp.checking.solids import Solid
from tamp.checking.transforms import inverse

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from tamp.task.plan import Trajectory

    Array = NDArray[np.float64]

FIRST_STEP = 0.05
"""Joint motion [rad] between the samples of the first, coarse grid."""


@dataclass(frozen=True, eq=False)
class Mover:
    """A body with its pose T_world_body at each sample, shape (n, 4, 4); one that stands still has n = 1."""

    solid: Solid
    T: Array

    @cached_property
    def center(self) -> Array:
        """Centre of the solid's sphere in the world at each sample, shape (n, 3)."""
        center: Array = self.T[:, :3, :3] @ self.solid.center + self.T[:, :3, 3]
        return center


@dataclass(frozen=True)
class Touch:
    """Two bodies closer than they may be: at which sample, and how deep they interpenetrate [m]."""

    sample: int
    bodies: tuple[str, str]
    depth: float


def sample_times(trajectory: Trajectory, movers: Callable[[Array], Sequence[Mover]], step: float) -> Array:
    """Times so dense that between two of them no point of any mover moves by more than `step` [m].

    Args:
        trajectory: a well-formed trajectory.
        movers: the bodies for configurations of shape (n, joints).
        step: the bound [m].
    """
    travel = np.abs(np.diff(trajectory.positions, axis=0)).max(axis=1)
    speed = np.abs(trajectory.velocities).max(axis=1)
    span = np.diff(trajectory.times)
    reach = np.maximum(travel, 1.5 * np.maximum(speed[:-1], speed[1:]) * span)
    times = _split(trajectory.times, np.ceil(reach / FIRST_STEP))
    while True:
        moved = np.max([travelled(m.solid, m.T) for m in movers(interpolate(trajectory, times))], axis=0)
        if (moved <= step).all():
            return times
        times = _split(times, np.where(moved > step, np.ceil(1.1 * moved / step), 1))


def _split(times: Array, counts: Array) -> Array:
    """Each span between two times divided into so many equal ones."""
    whole = np.maximum(counts, 1).astype(np.int64)
    span = np.repeat(np.diff(times) / whole, whole)
    first = np.repeat(times[:-1], whole)
    index = np.arange(whole.sum()) - np.repeat(np.cumsum(whole) - whole, whole)
    return np.append(first + index * span, times[-1])


def travelled(solid: Solid, T: Array) -> Array:
    """Bound on the distance any point of a solid moves from each pose to the next, shape (n - 1,) [m].

    A rotation by an angle moves points of a sphere round the centre by at most 2 sin(angle / 2) radii; that chord is
    the Frobenius norm of the difference of the rotations over sqrt(2).
    """
    center = T[:, :3, :3] @ solid.center + T[:, :3, 3]
    chord = np.linalg.norm(np.diff(T[:, :3, :3], axis=0), axis=(1, 2)) / np.sqrt(2.0)
    bound: Array = np.linalg.norm(np.diff(center, axis=0), axis=1) + chord * solid.radius
    return bound


def touches(pairs: Iterable[tuple[Mover, Mover, float]]) -> list[Touch]:
    """For each pair of bodies (a, b, allowed depth) the first sample where they are deeper than allowed, if any."""
    found = [touch for a, b, allowed in pairs if (touch := _first_touch(a, b, allowed)) is not None]
    return sorted(found, key=lambda touch: (touch.sample, touch.bodies))


def _first_touch(a: Mover, b: Mover, allowed: float) -> Touch | None:
    """Conservative advancement over samples (Mirtich 1996): a pair apart by d cannot touch before it has moved by d.

    The motion is that of b in the frame of a, so bodies that travel together cost one look.
    """
    between = b.center - a.center
    if np.einsum("ij,ij->i", between, between).min() > (a.solid.radius + b.solid.radius) ** 2:
        return None
    center = ((b.center - a.T[:, :3, 3])[:, None] @ a.T[:, :3, :3])[:, 0]
    beyond = np.maximum(np.maximum(a.solid.lower - center, center - a.solid.upper), 0.0)
    gap = np.sqrt((beyond * beyond).sum(axis=1)) - b.solid.radius
    if gap.min() > 0.0:
        return None
    T_a_b = inverse(a.T) @ b.T
    path = np.concatenate([[0.0], np.cumsum(travelled(b.solid, T_a_b))])
    k, n = 0, len(T_a_b)
    while k < n:
        room = float(gap[k])
        if room < 0.02:
            room = clearance(a.solid, b.solid, T_a_b[k], allowed)
        if room < -allowed:
            return Touch(k, (a.solid.name, b.solid.name), -room)
        k = max(k + 1, int(np.searchsorted(path, path[k] + room + allowed, side="right")))
    return None


def standing(solids: Mapping[str, Solid], poses: Mapping[str, Array]) -> list[Mover]:
    """Bodies that stand still, by name in order."""
    return [Mover(solids[name], poses[name][None]) for name in sorted(poses)]
