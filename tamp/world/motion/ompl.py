"""The one place that talks to OMPL: a feasible path between configurations, by a planner chosen by name."""

from __future__ import annotations

from typing import Any

import numpy as np
from ompl import base, geometric, util

from tamp import clock
from tamp.world.motion.paths import Array, StateChecker

# Names as the user writes them -> OMPL's classes; the first is the default. PRM is missing because its second thread
# and Python's interpreter lock wait for each other.
PLANNERS = {
    "rrtconnect": geometric.RRTConnect,
    "rrt": geometric.RRT,
    "kpiece": geometric.KPIECE1,
    "bkpiece": geometric.BKPIECE1,
    "lbkpiece": geometric.LBKPIECE1,
    "rrtstar": geometric.RRTstar,
    "informed-rrtstar": geometric.InformedRRTstar,
    "fmt": geometric.FMT,
    "bfmt": geometric.BFMT,
    "bitstar": geometric.BITstar,
    "aorrtc": geometric.AORRTC,
}

# These improve their path for as long as they are given time.
OPTIMISING = frozenset({"rrtstar", "informed-rrtstar", "bitstar", "aorrtc"})


class _Edges(base.MotionValidator):  # type: ignore[misc]
    """OMPL's question about an edge, passed to the checker as a whole."""

    def __init__(self, space: Any, checker: StateChecker, dof: int, resolution: float) -> None:
        super().__init__(space)
        self._edge_free, self._dof, self._resolution = checker.edge_free, dof, resolution

    def checkMotion(self, a: Any, b: Any) -> bool:
        """Whether the edge is free. OMPL takes a plain bool only: numpy's makes it fail with `bad_cast`."""
        return bool(self._edge_free(np.array(a[0 : self._dof]), np.array(b[0 : self._dof]), self._resolution))


def search(
    checker: StateChecker,
    lower: Array,
    upper: Array,
    start: Array,
    goals: Array,
    *,
    planner: str,
    seed: int,
    deadline: float,
    iterations: int,
    step: float,
    resolution: float,
) -> Array | None:
    """A path, shape (n, dof), from `start` (dof,) to one of `goals` (k, dof), or None where none was found in time.

    Args:
        checker: says which edges and configurations are free.
        lower: shape (dof,), bounds of the space [rad].
        upper: as lower.
        start: a free configuration.
        goals: free configurations.
        planner: a key of PLANNERS.
        seed: OMPL has one random generator a process, so it is reseeded here before each search.
        deadline: on the clock of tamp.clock.now() [s].
        iterations: how often the planner may ask whether to stop: a bound that repeats, unlike the clock.
        step: longest edge a tree grows by [rad], for the planners that have one.
        resolution: distance between the configurations tested on an edge [rad].
    """
    util.noOutputHandler()  # reseeding warns each time, and a search without result is no error of ours
    util.RNG.setSeed(1 + seed % (2**31 - 1))
    dof = len(start)
    space = base.RealVectorStateSpace(dof)
    bounds = base.RealVectorBounds(dof)
    for i in range(dof):  # a hair wider: OMPL refuses an end that exceeds a limit by a rounding error
        bounds.setLow(i, float(lower[i]) - 1e-8)
        bounds.setHigh(i, float(upper[i]) + 1e-8)
    space.setBounds(bounds)
    information = base.SpaceInformation(space)
    edges = _Edges(information, checker, dof, resolution)
    information.setMotionValidator(edges)
    information.setStateValidityChecker(lambda state: bool(checker.free(np.array(state[0:dof]))))
    information.setup()
    problem = base.ProblemDefinition(information)
    problem.addStartState(_state(space, start))
    goal = base.GoalStates(information)
    for q in goals:
        goal.addState(_state(space, q))
    problem.setGoal(goal)
    method = PLANNERS[planner](information)
    if hasattr(method, "setRange"):
        method.setRange(step)
    method.setProblemDefinition(problem)
    method.setup()
    left = iterations

    def stop() -> bool:
        nonlocal left
        left -= 1
        return left < 0 or clock.now() > deadline

    method.solve(base.PlannerTerminationCondition(stop))
    if not problem.hasExactSolution():
        return None
    return np.array([state[0:dof] for state in problem.getSolutionPath().getStates()])


def _state(space: Any, q: Array) -> Any:
    state = space.allocState()
    state[0 : len(q)] = [float(v) for v in q]
    return state
