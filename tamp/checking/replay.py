"""A plan being replayed: where everything is by now, and what was found wrong so far."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tamp.checking.verdict import Problem

if TYPE_CHECKING:
    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Action


@dataclass
class Replay:
    """What the rule of an action gets: the scene, the state that the rule brings forward, and where it reports.

    Attributes:
        scene: what never changes: solids of task and robot.
        state: where everything is; rules bring it to the end of their action.
        allow: tolerances.
        problems: what was found so far.
    """

    scene: Scene
    state: State
    allow: Tolerances
    problems: list[Problem] = field(default_factory=list)
    _index: int | None = None
    _name: str = "start"

    def begin(self, index: int | None, name: Action | str) -> None:
        """Name what the reports that follow are about: an action and its index, or "start" or "goal" without one."""
        self._index, self._name = index, str(name)

    def report(
        self, kind: str, sentence: str, bodies: tuple[str, ...] = (), depth: float = 0.0, after: float = 0.0
    ) -> None:
        """Note a problem, `after` seconds into the present step; kinds as in `Problem`."""
        time = self.state.time + after
        self.problems.append(Problem(self._index, self._name, time, kind, bodies, depth, sentence))
