"""Simulators that do not come to an end, in one way or another."""

import contextlib
import os
import time

from tamp.execution.pybullet.simulator import PyBulletSimulator


class Sleeps(PyBulletSimulator):
    """Falls asleep in the middle."""

    def step(self, count: int = 1) -> None:
        """Let `count` steps pass, but for that."""
        if self.time > 0.5:
            time.sleep(1e6)
        super().step(count)


class Stubborn(PyBulletSimulator):
    """Is busy for ever, and lets nobody interrupt it."""

    def step(self, count: int = 1) -> None:
        """Let `count` steps pass, but for that."""
        while self.time > 0.5:
            with contextlib.suppress(BaseException):
                time.sleep(0.01)
        super().step(count)


class Ends(PyBulletSimulator):
    """Ends the process from below."""

    def step(self, count: int = 1) -> None:
        """Let `count` steps pass, but for that."""
        if self.time > 0.5:
            os._exit(0)
        super().step(count)
