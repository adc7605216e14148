"""How fast a path may be followed where: TOPPRA's reachability analysis under velocity and acceleration limits."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from tamp.world.motion.paths import Array
from tamp.world.timing.blending import RoundedPath
from tamp.world.timing.deferred_import import deferred

with deferred("matplotlib", "matplotlib.pyplot"), deferred("scipy.interpolate"):
    from toppra import algorithm, constraint


def fastest_rates(curve: RoundedPath, grid: Array, velocity: Array, acceleration: Array) -> Array:
    """The path's fastest rate ds/dt at each point of the grid, zero at both ends.

    Between two points of the grid d2s/dt2 and the curve's second derivative are constant, so a limit that holds at
    both ends of an interval (TOPPRA's Interpolation discretisation) holds within.

    Args:
        curve: the path.
        grid: shape (m,), increasing arc lengths from one end of the curve to the other [rad].
        velocity: shape (dof,), largest velocities [rad/s].
        acceleration: shape (dof,), largest accelerations [rad/s2].

    Raises:
        ArithmeticError: where TOPPRA finds no timing.
    """
    limits = _constraints(tuple(velocity), tuple(acceleration))
    instance = algorithm.TOPPRA(list(limits), _Geometry(curve), gridpoints=grid, solver_wrapper="seidel")
    _, rates, _ = instance.compute_parameterization(0.0, 0.0)
    if rates is None or not np.isfinite(rates).all():
        raise ArithmeticError(f"TOPPRA found no timing of a path of {len(curve.corners)} corners")
    return np.asarray(rates, dtype=float)


@lru_cache(maxsize=16)
def _constraints(velocity: tuple[float, ...], acceleration: tuple[float, ...]) -> tuple[Any, Any]:
    """TOPPRA's form of the limits; kept, because making it costs as much as half of a timing."""
    return (
        constraint.JointVelocityConstraint([(-v, v) for v in velocity]),
        constraint.JointAccelerationConstraint(
            [(-a, a) for a in acceleration],
            discretization_scheme=constraint.DiscretizationType.Interpolation,
        ),
    )


class _Geometry:
    """A rounded path in the form that TOPPRA asks for."""

    def __init__(self, curve: RoundedPath) -> None:
        self._curve = curve
        self.dof = curve.corners.shape[1]
        self.path_interval = np.array([0.0, curve.arc[-1]])

    def __call__(self, s: Any, order: int = 0) -> Array:
        values = self._curve(np.atleast_1d(s), order)
        return values if np.ndim(s) else values[0]
