"""Collision-free motion between configurations: the straight edge, else OMPL, then shortcuts. Geometry, no time."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import Any, Protocol

import numpy as np

from tamp import clock
from tamp.errors import meant
from tamp.world.motion.paths import RESOLUTION, Array, StateChecker, shortcut, without_duplicates
from tamp.world.robot.model import RobotModel

ITERATIONS = 100_000
"""How often a planner may extend its trees before it gives up, whatever the clock says."""

PORTFOLIO = "portfolio"

TURNS = (("rrtconnect", 60, 1), ("lbkpiece", 180, 16))
"""The planners of the portfolio, the length of each one's first turn in iterations of RRT-Connect, and how many of its
own iterations take as long as one of those. Four of five queries in clutter need fewer than 60; the rest are pockets.
"""


@dataclass(frozen=True, eq=False)
class MotionResult:
    """A path, or the reason why there is none.

    Attributes:
        path: shape (n, dof) [rad], free of collision, n >= 2; None where none was found.
        reason: "" where a path was found, else one clause that says why not.
        planning_s: time until the first path [wall seconds].
        simplify_s: time to shorten and recheck it [wall seconds].
        bodies: the two bodies in contact where the start or the goal is in collision, as the checker names them.
        exhausted: whether the search ended for lack of time or iterations: no proof that there is no path.
    """

    path: Array | None
    reason: str
    planning_s: float
    simplify_s: float = 0.0
    bodies: tuple[str, ...] = ()
    exhausted: bool = False


def planner_names() -> tuple[str, ...]:
    """Names that `plan_motion` takes as `planner`, the default first."""
    from tamp.world.motion.ompl import PLANNERS

    return (PORTFOLIO, *PLANNERS)


def plan_motion(
    checker: StateChecker,
    lower: Array,
    upper: Array,
    q_start: Array,
    q_goal: Array,
    *,
    seed: int,
    timeout: float,
    planner: str = PORTFOLIO,
    iterations: int = ITERATIONS,
    shortcuts: int = 20,
    step: float = 0.5,
    recheck: float = RESOLUTION / 2,
) -> MotionResult:
    """Plan a path from a configuration to another, or to any of several.

    The result depends on the arguments alone, except where the clock ends the search.

    Args:
        checker: says which configurations and edges are free.
        lower: shape (dof,), joint limits [rad].
        upper: as lower.
        q_start: shape (dof,) [rad].
        q_goal: shape (dof,), or (k, dof) where any of k configurations will do; those that are not free are ignored.
        seed: of the planner and of the shortcuts.
        timeout: time for the search [wall seconds].
        planner: one of planner_names(). "portfolio" gives RRT-Connect, which is at home in open space, and LBKPIECE,
            which leaves narrow pockets quickly, turns of doubling length. Each turn begins anew, so that
            an unlucky tree costs no more than its turn.
        iterations: bound of the search that repeats from run to run, unlike the timeout; in the portfolio counted in
            iterations of RRT-Connect, a thousand of which take about 0.1 to 0.3 s.
        shortcuts: attempts to shorten the path; 0 leaves it as found.
        step: longest edge that a tree grows by [rad].
        recheck: distance between the configurations at which the path is rechecked before it is handed out [rad]; with
            a margin under 2 mm, 0.01 keeps fingertips from passing through an edge between two of them.

    Raises:
        ValueError: for an unknown planner, or arrays whose shapes do not fit.
    """
    begin = clock.now()
    lower, upper, start = (np.asarray(a, dtype=float) for a in (lower, upper, q_start))
    goals = np.atleast_2d(np.asarray(q_goal, dtype=float))
    if planner != PORTFOLIO and planner not in planner_names():
        near, known = meant(planner, planner_names()), ", ".join(planner_names())
        raise ValueError(f"unknown motion planner {planner!r}; {near}there are {known}")
    if not len(lower) == len(upper) == len(start) == goals.shape[1]:
        raise ValueError(f"start {start.shape}, goal {goals.shape} and limits {lower.shape} differ in their joints")
    at_start = _obstacle(checker, lower, upper, start, "start")
    at_goals = [_obstacle(checker, lower, upper, goal, "goal") for goal in goals]
    hopeless = at_start or (at_goals[0] if all(at_goals) else None)
    if hopeless:
        return MotionResult(None, hopeless[0], clock.now() - begin, bodies=hopeless[1])
    goals = goals[[obstacle is None for obstacle in at_goals]]
    goals = goals[np.argsort(np.linalg.norm(goals - start, axis=1), kind="stable")]
    for goal in goals:
        if checker.edge_free(start, goal, recheck):
            return MotionResult(np.array([start, goal]), "", clock.now() - begin)

    from tamp.world.motion.ompl import OPTIMISING, search

    # A corner touched between two tested configurations shows in the finer recheck; then all is searched anew, finer.
    simplify_s, resolution = 0.0, recheck if planner in OPTIMISING else RESOLUTION
    for turn, (name, budget) in enumerate(_turns(planner, iterations)):
        found = search(
            checker, lower, upper, start, goals,
            planner=name, seed=seed + turn, deadline=begin + timeout, iterations=budget,
            step=step, resolution=resolution,
        )  # fmt: skip
        if found is not None:
            planned = clock.now()
            path = _shortened(checker, without_duplicates(found), seed, shortcuts, resolution, recheck)
            simplify_s += clock.now() - planned
            if path is not None:
                return MotionResult(path, "", clock.now() - begin - simplify_s, simplify_s)
            resolution = recheck
        elif planner != PORTFOLIO:
            break
        if clock.now() > begin + timeout:
            break
    spent = clock.now() - begin
    return MotionResult(None, f"no path found in {spent:.2f} s", spent - simplify_s, simplify_s, exhausted=True)


def _turns(planner: str, iterations: int) -> Iterator[tuple[str, int]]:
    """Planners and how many iterations each gets, in order; a portfolio's together cost `iterations`."""
    if planner != PORTFOLIO:
        yield from ((planner, iterations), (planner, iterations))  # again, finer, where the recheck refuses a path
        return
    growth = 1
    while iterations > 0:
        for name, first, weight in TURNS:
            if (turn := min(growth * first, iterations)) == 0:
                return
            yield name, weight * turn
            iterations -= turn
        growth *= 2


def _shortened(
    checker: StateChecker, found: Array, seed: int, shortcuts: int, resolution: float, recheck: float
) -> Array | None:
    """The path shortened; where that fails the recheck, shortened as finely as that; else as found, or None."""

    def shorter(spacing: float) -> Array:
        return shortcut(found, checker, np.random.default_rng(seed), attempts=shortcuts, resolution=spacing)

    finer = (recheck,) if recheck < resolution else ()
    for path in chain(map(shorter, (resolution, *finer)), (found,)):
        if all(checker.edge_free(a, b, recheck) for a, b in pairwise(path)):
            return path
    return None


def _obstacle(
    checker: StateChecker, lower: Array, upper: Array, q: Array, which: str
) -> tuple[str, tuple[str, ...]] | None:
    """Why a configuration cannot be an end of a path, and which bodies touch there; None where it can."""
    beyond = np.flatnonzero((q < lower - 1e-9) | (q > upper + 1e-9))
    if beyond.size:
        i = int(beyond[0])
        return f"the {which} has joint {i + 1} at {q[i]:.4f}, beyond its limits [{lower[i]:.4f}, {upper[i]:.4f}]", ()
    contact = checker.contact(q)
    if contact is None:
        return None
    return f"the {which} is in collision: {contact}", (contact.a, contact.b)


CAPACITY = 2048


class KnownChecker(StateChecker, Protocol):
    """A checker whose answers can be remembered."""

    robot: RobotModel

    @property
    def fingerprint(self) -> bytes:
        """Equal for checkers that answer every question alike."""


class MotionCache:
    """Remembers answers by everything that decides them, the least recently asked forgotten first.

    An answer that the clock cut short is not kept: asked again with more time, it may come out otherwise.
    """

    def __init__(self, capacity: int = CAPACITY, planner: str = PORTFOLIO) -> None:
        """`planner`: by which questions are answered that name none."""
        self._answers: OrderedDict[Any, MotionResult] = OrderedDict()
        self._capacity = capacity
        self._planner = planner
        self.hits = 0

    def plan(
        self,
        checker: KnownChecker,
        q_start: np.ndarray,
        q_goal: np.ndarray,
        *,
        seed: int,
        timeout: float,
        **options: Any,
    ) -> MotionResult:
        """As `plan_motion`, within the joint limits of the checker's robot.

        Args:
            checker: the scene.
            q_start: shape (dof,) [rad].
            q_goal: shape (dof,), or (k, dof) where any of k will do [rad].
            seed: of the planner and of the shortcuts.
            timeout: time for the search [wall seconds]; no part of the question.
            options: as `plan_motion` takes them.
        """
        ends = (np.ascontiguousarray(q_start).tobytes(), np.ascontiguousarray(q_goal).tobytes())
        key = (checker.fingerprint, *ends, seed, tuple(sorted(options.items())))
        known = self._answers.get(key)
        if known is not None:
            self._answers.move_to_end(key)
            self.hits += 1
            return known
        robot, options = checker.robot, {"planner": self._planner, **options}
        answer = plan_motion(checker, robot.lower, robot.upper, q_start, q_goal, seed=seed, timeout=timeout, **options)
        if not answer.exhausted:
            self._answers[key] = answer
            if len(self._answers) > self._capacity:
                self._answers.popitem(last=False)
        return answer
