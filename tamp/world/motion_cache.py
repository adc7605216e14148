"""Motion queries already answered: the same scene, ends and seed are not searched twice."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

import numpy as np

from tamp.world.collision import CollisionChecker
from tamp.world.motion import MotionResult, plan_motion

CAPACITY = 2048


class MotionCache:
    """Remembers answers by everything that decides them, the least recently asked forgotten first.

    An answer that the clock cut short is not kept: asked again with more time, it may come out otherwise.
    """

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._answers: OrderedDict[Any, MotionResult] = OrderedDict()
        self._capacity = capacity
        self.hits = 0

    def plan(
        self,
        checker: CollisionChecker,
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
        robot = checker.robot
        answer = plan_motion(checker, robot.lower, robot.upper, q_start, q_goal, seed=seed, timeout=timeout, **options)
        if not answer.exhausted:
            self._answers[key] = answer
            if len(self._answers) > self._capacity:
                self._answers.popitem(last=False)
        return answer
