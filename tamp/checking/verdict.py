"""What the checker says: accepted, or which action is wrong, when, between which bodies, by how much."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tamp.checking.scene import State


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing wrong with a plan.

    Attributes:
        action: index of the action in the plan, or None where no single action is to blame.
        name: that action as text, such as "pick(cup)", or "start" or "goal".
        time: when, counted over all arm motions from the start of the plan [s].
        kind: "start", "precondition", "continuity", "limits", "collision", "grasp", "release", "fall", "push",
            "support" or "goal".
        bodies: the bodies concerned; links by their URDF name, the table as "table".
        depth: penetration or distance of the error where there is one [m], else 0.
        sentence: what is wrong, in words.
    """

    action: int | None
    name: str
    time: float
    kind: str
    bodies: tuple[str, ...]
    depth: float
    sentence: str

    def __str__(self) -> str:
        where = self.name if self.action is None else f"action {self.action}, {self.name}, at {self.time:.2f} s"
        return f"{where}: {self.sentence}"


@dataclass(frozen=True, slots=True)
class Verdict:
    """The checker's word on a plan: accepted where there is no problem, else every problem found, in order of time.

    Attributes:
        problems: what is wrong.
        facts: the symbolic facts that hold at the end, as the rules of its actions keep them.
        state: what the checker knows of the world at the end, for a check of what follows; None if it checked nothing.
    """

    problems: tuple[Problem, ...] = ()
    facts: frozenset[tuple[str, ...]] = frozenset()
    state: State | None = field(default=None, compare=False, repr=False)

    @property
    def accepted(self) -> bool:
        """Whether the plan is right in every respect."""
        return not self.problems

    @property
    def executable(self) -> bool:
        """Whether a robot could carry the plan out: nothing is wrong but, at most, goals that it does not reach."""
        return all(problem.kind == "goal" for problem in self.problems)

    def __str__(self) -> str:
        if self.accepted:
            return "accepted"
        lines = [f"rejected: {len(self.problems)} problem{'s' if len(self.problems) > 1 else ''}"]
        return "\n".join([*lines, *(f"  {problem}" for problem in self.problems)])
