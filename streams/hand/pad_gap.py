"""How far apart an object holds the pads that press on it, and how it turns to let them come nearer; compiled.

The pads are felt for along rays between them, through the convex parts that lie there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.geometry.half_spaces import Planes

    Array = NDArray[np.float64]
    Indices = NDArray[np.int64]

    Between = tuple[Planes, Array, Array, float]
    """What lies between two pads: the planes of its convex parts; a centre and a radius for each, of a ball around it,
    shape (parts, 4) [m]; where rays along the closing axis, which is y, begin: midway between the pads, shape (r, 3)
    [m]; and what meets a ray farther from there than half of this lies beyond the pads [m]."""

ROUNDING = 1e-9  # [m]
TURN_STEP = 0.04  # between the angles looked at [rad]
FARTHEST_TURN = 0.7  # it is enough to know that it turns this far [rad]
MOST_STEPS = 18  # about one axis, at once


@compiled
def within(
    vertices: Array, starts: Indices, planes: Planes, balls: Array, R: Array, t: Array, half: Array
) -> tuple[Planes, Array]:
    """Planes and balls of those convex parts that are, moved by R and t, in a box about the origin.

    Args:
        vertices: of all parts, shape (n, 3) [m].
        starts: where each part's vertices begin among them, shape (parts,).
        planes: of all parts.
        balls: a centre and a radius for each part, of a ball around it, shape (parts, 4) [m].
        R: shape (3, 3).
        t: shape (3,) [m].
        half: half the size of the box, shape (3,) [m].
    """
    A, b, ends = planes
    turned, offsets = np.empty(A.shape), np.empty(len(b))
    kept_ends, kept_balls = np.empty(len(ends), np.int64), np.empty(balls.shape)
    count = parts = 0
    for part in range(len(ends)):
        last = starts[part + 1] if part + 1 < len(starts) else len(vertices)
        if not _reaches(vertices[starts[part] : last], R, t, half):
            continue
        for m in range(ends[part - 1] if part else 0, ends[part]):
            offsets[count] = b[m]
            for i in range(3):
                turned[count, i] = R[i, 0] * A[m, 0] + R[i, 1] * A[m, 1] + R[i, 2] * A[m, 2]
                offsets[count] += turned[count, i] * t[i]
            count += 1
        for i in range(3):
            kept_balls[parts, i] = R[i, 0] * balls[part, 0] + R[i, 1] * balls[part, 1] + R[i, 2] * balls[part, 2] + t[i]
        kept_ends[parts], kept_balls[parts, 3] = count, balls[part, 3]
        parts += 1
    return (turned[:count].copy(), offsets[:count].copy(), kept_ends[:parts].copy()), kept_balls[:parts].copy()


@compiled
def _reaches(vertices: Array, R: Array, t: Array, half: Array) -> bool:
    """Whether the box around a part, moved by R and t, reaches into one about the origin."""
    for i in range(3):
        low, high = np.inf, -np.inf
        for v in range(len(vertices)):
            at = R[i, 0] * vertices[v, 0] + R[i, 1] * vertices[v, 1] + R[i, 2] * vertices[v, 2] + t[i]
            low, high = min(low, at), max(high, at)
        if low >= half[i] or high <= -half[i]:
            return False
    return True


@compiled
def apart(between: Between, turns: Array, shifts: Array) -> Array:
    """How far apart the pads stand with all of it turned and then moved, in each of n ways, shape (n,) [m].

    Args:
        between: what lies between them.
        turns: rotations, shape (n, 3, 3).
        shifts: shape (n, 3) [m].
    """
    found = np.empty(len(turns))
    for k in range(len(turns)):
        found[k] = _apart_at(between, turns[k], shifts[k])
    return found


@compiled
def turned(between: Between, force: float, pull: Array, resisted: float) -> Array:
    """The rotation that it makes, shape (3, 3); where it has turned about one axis, it may go on about the other.

    It goes on about an axis, the side or the approach direction of the pads, as long as each step sets free more energy
    than it takes, alone or with the next.

    Args:
        between: what lies between the pads.
        force: that each pad presses with [N].
        pull: energy of the object at a rotation R is the sum of pull * R, shape (3, 3) [J].
        resisted: what friction takes of the energy for each step [J].
    """
    turn, steps = np.eye(3), 1
    while steps > 0 and _angle(turn) < FARTHEST_TURN:
        still = _energy(between, force, pull, turn)
        steps, start = 0, turn
        for axis in (0, 2):
            for step in (TURN_STEP, -TURN_STEP):
                reached = _steps(between, force, pull, start, still, axis, step, resisted)
                if reached > steps:
                    steps, turn = reached, _about(axis, reached * step, start)
    return turn


@compiled
def _steps(
    between: Between, force: float, pull: Array, turn: Array, still: float, axis: int, step: float, resisted: float
) -> int:
    """How many steps about an axis it goes on from a rotation, where its energy is `still`."""
    reached, least = 0, still
    for count in range(1, MOST_STEPS + 1):
        spent = _energy(between, force, pull, _about(axis, count * step, turn)) + count * resisted
        if spent < least:
            reached, least = count, spent
        elif count > reached + 1:
            break
    return reached


@compiled
def _energy(between: Between, force: float, pull: Array, turn: Array) -> float:
    """Of pads and object at a rotation [J]."""
    return float(force * _apart_at(between, turn, np.zeros(3)) + (pull * turn).sum())


@compiled
def _about(axis: int, angle: float, turn: Array) -> Array:
    """A rotation, followed by one about a coordinate axis, shape (3, 3)."""
    c, s, found = np.cos(angle), np.sin(angle), turn.copy()
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found[i], found[j] = c * turn[i] - s * turn[j], s * turn[i] + c * turn[j]
    return found


@compiled
def _angle(turn: Array) -> float:
    """By how much a rotation (3, 3) turns [rad]."""
    return float(np.arccos(min(1.0, max(-1.0, (turn[0, 0] + turn[1, 1] + turn[2, 2] - 1.0) / 2.0))))


@compiled
def _apart_at(between: Between, turn: Array, shift: Array) -> float:
    """How far apart the pads stand with all of it turned by one rotation, and then moved [m]."""
    (A, b, ends), balls, origins, width = between
    turned, offset = np.empty((len(A), 3)), b.copy()
    for m in range(len(A)):
        for i in range(3):
            turned[m, i] = turn[i, 0] * A[m, 0] + turn[i, 1] * A[m, 1] + turn[i, 2] * A[m, 2]
            offset[m] += turned[m, i] * shift[i]
    low, high, first = np.inf, -np.inf, 0
    for part in range(len(ends)):
        ball, end = balls[part], ends[part]
        x = turn[0, 0] * ball[0] + turn[0, 1] * ball[1] + turn[0, 2] * ball[2] + shift[0]
        z = turn[2, 0] * ball[0] + turn[2, 1] * ball[1] + turn[2, 2] * ball[2] + shift[2]
        for ray in range(len(origins)):
            if (origins[ray, 0] - x) ** 2 + (origins[ray, 2] - z) ** 2 > (ball[3] + ROUNDING) ** 2:
                continue
            enter, leave = _crossed(turned[first:end], offset[first:end], origins[ray])
            if enter < leave and abs(enter + leave) < width + 0.002:
                low, high = min(low, enter), max(high, leave)
        first = end
    return max(high - low, 0.0)


@compiled
def _crossed(A: Array, b: Array, origin: Array) -> tuple[float, float]:
    """Where a ray along y from an origin (3,) enters and leaves the body A x <= b; it leaves first where it misses."""
    enter, leave = -np.inf, np.inf
    for m in range(len(A)):
        gap = b[m] - A[m, 0] * origin[0] - A[m, 1] * origin[1] - A[m, 2] * origin[2]
        if A[m, 1] > 1e-9:
            leave = min(leave, gap / A[m, 1])
        elif A[m, 1] < -1e-9:
            enter = max(enter, gap / A[m, 1])
        elif gap < 0.0:
            return np.inf, -np.inf
        if enter >= leave:
            return np.inf, -np.inf
    return enter, leave
