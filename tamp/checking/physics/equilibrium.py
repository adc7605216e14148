"""Does a body rest on what it touches? Contact forces within friction cones that balance its weight.

The places of the centre of mass at which such forces exist form a convex region (Bretl and Lall, "Testing static
equilibrium for legged robots", IEEE Transactions on Robotics 24(4), 2008). Where all contacts are level it is the
support polygon; else each question is a linear program over the edges of linearised friction cones, solved by HiGHS.
What the body touches is taken not to give way, and rigid bodies could press each other as hard as they like: a slot of
a millimetre would hold a shelf. Weight does not press so hard, and all contact forces together are bounded.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.physics.least_squares import nnls

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LEVEL = 0.9999
"""Vertical component from which a contact normal counts as vertical: within 0.8 degrees."""
EDGES = 12
"""Edges of a linearised cone, which lies inside the true one and leaves out at most 3.4 % of the friction."""
DIRECTIONS = 16
"""Of the fan in which the outermost contacts are kept: those between them change nothing."""
ZERO = 1e-6
"""Distances of a program's solution that are rounding [m]."""
FEW = 96
"""Pushes that are asked at first, and added at a time."""
GAIN = 1e-9
"""Reduced costs that are rounding [m]."""
TINY = 1e-12
"""Points no farther from a line lie on it [m]."""
SCALE = 0.05
"""Length by which moments are divided, so that they are of the order of the forces [m]."""

STEEP = 0.02
"""Share of a weight that pushes leave without a hold where they do not hold it up."""

VERGE = 1.05
"""Share of friction with which a body must keep its balance where its centre of mass shifts: what comes to rest by
sliding stops where friction just holds it, and has no margin but in where it is touched."""

PRESSED = 20.0
"""All contact forces together, in weights: what hangs out of a slot a times as far as it is in it takes 2 a + 1."""

SHIFTS = np.array([[0.0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, -1, 1], [1, -1, 0, 0], [0, 0, 0, 0]])
"""Scaled moments that a unit weight gains where its centre of mass shifts along x, -x, y, -y, shape (6, 4)."""


def balance(points: Array, normals: Array, friction: Array, center: Array, wanted: float) -> float:
    """How well a body rests on its contacts.

    Args:
        points: where it is touched, shape (n, 3) [m], in the world.
        normals: unit normals there, into the body, shape (n, 3).
        friction: coefficient at each contact, shape (n,).
        center: its centre of mass, shape (3,).
        wanted: how far the centre of mass may shift, along x and y, without the body losing its balance [m], though
            friction be by `VERGE` greater then.

    Returns:
        At least `wanted` where it rests so well; else minus the distance by which the centre of mass would have to lie
        elsewhere [m], or how far it may shift where that is positive; minus infinity where no place of it helps.
    """
    if not len(points):
        return -np.inf
    if (normals[:, 2] > LEVEL).all():
        return float(inside(points[:, :2], center[None, :2])[0])
    kept = outermost(points, normals)
    outside = _shortfall(wrenches(points[kept] - center, normals[kept], friction[kept]), (0.0, 0.0))
    if outside > ZERO or wanted <= 0.0:
        return -outside if outside > ZERO else 0.0
    pushes = wrenches(points[kept] - center, normals[kept], VERGE * friction[kept])
    missing = max(_shortfall(pushes, (x, y)) for x in (-wanted, wanted) for y in (-wanted, wanted))
    return wanted if missing < ZERO else wanted - missing


def holds_up(normals: Array, friction: float) -> bool:
    """Whether pushes along unit normals, shape (n, 3), within friction, add up to a force straight up."""
    apart = normals[np.unique(np.round(normals, 2), axis=0, return_index=True)[1]]
    pushes = wrenches(np.zeros_like(apart), apart, np.full(len(apart), friction))[:3]
    return bool(nnls(pushes, np.array([0.0, 0.0, 1.0]))[1] < STEEP)


def along(normals: Array, way: Array) -> Array:
    """The part of a vector, shape (3,), that pushes along unit normals, shape (n, 3), can add up to."""
    part: Array = normals.T @ nnls(normals.T, way)[0]
    return part


def holds_ahead(arms: Array, normals: Array, friction: float, ahead: Array) -> bool:
    """Whether pushes along unit normals, within friction, add up to a level force along `ahead`, without a moment.

    What slides along something level needs no more: that bears what presses it down.

    Args:
        arms: where it is pushed, from the place about which there is no moment about the vertical, shape (n, 3) [m].
        normals: unit normals there, into the body, shape (n, 3).
        friction: coefficient of the contacts.
        ahead: level unit vector, shape (3,).
    """
    aside = np.stack([-normals[:, 1], normals[:, 0], np.zeros(len(normals))], axis=1)
    aside /= np.maximum(np.linalg.norm(aside, axis=1), ZERO)[:, None]
    forces = np.concatenate([normals + friction * aside, normals - friction * aside])
    moments = np.cross(np.tile(arms, (2, 1)), forces)[:, 2] / SCALE
    pushes = np.stack([forces[:, 0], forces[:, 1], moments])
    return bool(nnls(pushes, np.array([ahead[0], ahead[1], 0.0]))[1] < STEEP)


def pressed(arms: Array, normals: Array, friction: float, force: Array) -> float:
    """The least force with which each of two fingers must press, so that all pushes add up to a force [N].

    Args:
        arms: where they touch a body, from the place where the force acts, shape (n, 3) [m].
        normals: unit normals there, into the body, shape (n, 3); fingers are told apart by the way that these point.
        friction: coefficient of the contacts.
        force: shape (3,) [N].

    Returns:
        Infinity where no force is enough.
    """
    from scipy.optimize import linprog

    pushes = wrenches(arms, normals, np.full(len(arms), friction))
    count = pushes.shape[1]
    sides = np.repeat(normals @ normals[0] > 0.0, count // len(arms))
    each = np.stack([np.append(sides, -1.0), np.append(~sides, -1.0)])
    wanted = np.concatenate([force, np.zeros(3)])
    found = linprog(
        np.append(np.zeros(count), 1.0),
        A_ub=each,
        b_ub=np.zeros(2),
        A_eq=np.hstack([pushes, np.zeros((6, 1))]),
        b_eq=wanted,
        bounds=(0.0, None),
    )
    return float(found.x[-1]) if found.status == 0 else np.inf


def inside(points: Array, centers: Array) -> Array:
    """Signed distances of places from the convex hull of points in the plane, shape (m,) [m]; positive inside.

    The hull holds a place by a margin d just if for every direction some point lies at least d that way of it;
    directions worth asking are the normals of the hull's edges, which a fine fan of directions stands for.

    Args:
        points: shape (n, 2).
        centers: the places, shape (m, 2).
    """
    angle = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    fan = np.stack([np.cos(angle), np.sin(angle)])
    corners = points[np.unique((points @ fan[:, ::6]).argmax(axis=0))]  # the hull but for 0.1 % of its size
    margins: Array = ((corners @ fan).max(axis=0) - centers @ fan).min(axis=1)
    return margins


def reach(points: Array, center: Array, ahead: Array) -> float:
    """How far from a place on, straight ahead, the convex hull of points in the plane reaches [m].

    A push that overcomes friction shifts what carries a body's weight ahead by its height times friction, along the
    line of the push: the body tips as soon as that leaves its support polygon there, however far that reaches aside.

    Args:
        points: shape (n, 2).
        center: the place, shape (2,).
        ahead: unit vector, shape (2,).

    Returns:
        Minus infinity where the hull is not ahead of the place at all.
    """
    angle = np.linspace(0.0, 2 * np.pi, 180, endpoint=False)
    fan = np.stack([np.cos(angle), np.sin(angle)])
    corners = points[np.unique((points @ fan).argmax(axis=0))] - center if len(points) else points
    along, across = corners @ ahead, corners @ [-ahead[1], ahead[0]]
    left, right = across >= 0.0, across <= 0.0
    a, b, x, y = across[left][:, None], -across[right], along[left][:, None], along[right]
    crossing = (x * b + y * a) / np.maximum(a + b, TINY)
    return float(np.where(a + b > TINY, crossing, np.maximum(x, y)).max(initial=-np.inf))


def outermost(points: Array, normals: Array) -> Array:
    """Indices of the contacts that span those with the same normal."""
    thousandths = np.rint(1000 * normals).astype(np.int64)
    _, groups = np.unique(thousandths @ (10**8, 10**4, 1), return_inverse=True)
    angle = np.linspace(0.0, 2 * np.pi, DIRECTIONS, endpoint=False)
    kept = []
    for group in range(groups.max() + 1):
        members = np.flatnonzero(groups == group)
        along, across = _tangents(normals[members[:1]])
        fan = np.cos(angle)[:, None] * along + np.sin(angle)[:, None] * across
        kept.append(members[np.unique((points[members] @ fan.T).argmax(axis=0))])
    return np.concatenate(kept)


def wrenches(arms: Array, normals: Array, friction: Array) -> Array:
    """Force and scaled moment of unit pushes along the edges of each contact's cone, shape (6, n * EDGES)."""
    along, across = _tangents(normals)
    angle = np.linspace(0.0, 2 * np.pi, EDGES, endpoint=False)[None, :, None]
    slip = np.cos(angle) * along[:, None] + np.sin(angle) * across[:, None]
    forces = (normals[:, None] + friction[:, None, None] * slip).reshape(-1, 3)
    moments = np.cross(np.repeat(arms, EDGES, axis=0), forces) / SCALE
    return np.concatenate([forces.T, moments.T])


def _tangents(normals: Array) -> tuple[Array, Array]:
    """Two unit vectors across each normal and each other, each of shape (n, 3)."""
    helper = np.where(np.abs(normals[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    along = np.cross(helper, normals)
    along /= np.linalg.norm(along, axis=1)[:, None]
    return along, np.cross(normals, along)


def _shortfall(wrenches: Array, shift: tuple[float, float]) -> float:
    """Least further shift |x| + |y| of the centre of mass at which pushes balance a unit weight [m]; inf without one.

    The weight (0, 0, -1) at (x, y, 0) has the moment (-y, x, 0) about the origin. Few pushes carry it, so that few are
    asked at first, and of the others those whose reduced cost is negative, until there is none (column generation;
    Dantzig and Wolfe, "Decomposition principle for linear programs", Operations Research 8(1), 1960).
    """
    target = np.array([0.0, 0.0, 1.0, shift[1] / SCALE, -shift[0] / SCALE, 0.0])
    asked = np.arange(0, wrenches.shape[1], max(1, wrenches.shape[1] // FEW))
    while True:
        least, prices = _program(wrenches[:, asked], target)
        gains = prices[:-1] @ wrenches + prices[-1]
        gains[asked] = 0.0
        better = np.argsort(-gains)[:FEW]
        better = better[gains[better] > GAIN]
        if np.isinf(least) and len(asked) < wrenches.shape[1]:
            asked = np.arange(wrenches.shape[1])
        elif np.isinf(least) or not len(better):
            return least
        else:
            asked = np.concatenate([asked, better])


def _program(wrenches: Array, target: Array) -> tuple[float, Array]:
    """The least shift with some pushes only, infinite without one; dual prices of the six balances and the bound."""
    solved = least(wrenches, SHIFTS, np.full(4, SCALE), target, PRESSED)
    return (float(SCALE * solved[0].sum()), solved[1]) if solved is not None else (np.inf, np.zeros(7))


def least(pushes: Array, shifts: Array, costs: Array, target: Array, pressed: float) -> tuple[Array, Array] | None:
    """The least shifts with which pushes balance weights, by HiGHS.

    Args:
        pushes: what a unit of each push gives, shape (m, n).
        shifts: the same of each shift, shape (m, k).
        costs: of each shift, shape (k,).
        target: what they shall give together, shape (m,).
        pressed: the most that all pushes may amount to.

    Returns:
        The shifts, shape (k,), and the dual prices of the m balances and the bound; None where nothing balances.
    """
    from scipy.optimize import linprog

    count = pushes.shape[1]
    cost, columns = np.concatenate([np.zeros(count), costs]), np.hstack([pushes, shifts])
    amount = np.concatenate([np.ones(count), np.zeros(len(costs))])[None]
    found = linprog(cost, A_eq=columns, b_eq=target, A_ub=amount, b_ub=[pressed], method="highs")
    if found.status != 0:
        return None
    return found.x[count:], np.append(found.eqlin.marginals, found.ineqlin.marginals)
