"""What an object can reach alone, with all others out of the way: what cannot reach its goal even so waits for none."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

from tamp.pipeline.asking import Asker
from tamp.pipeline.efforts import ALONE
from tamp.pipeline.goals import alone, goal_supports, supports_first, supports_in_the_way
from tamp.pipeline.reasons import reason
from tamp.streams.flat_faces import lies_flat
from tamp.streams.values import Placement


@dataclass
class Prospects:
    """What short tries say of single objects; each object is tried once, from where it stands by then.

    Attributes:
        asker: the plan so far.
        hopeless: object that does not reach its goal even alone -> where it stood then, and why.
        regrasped: objects that reach theirs alone by way of another grasp.
    """

    asker: Asker
    hopeless: dict[str, tuple[Placement, str]] = field(default_factory=dict)
    regrasped: set[str] = field(default_factory=set)
    _hopeful: set[str] = field(default_factory=set)

    def known_against(self, name: str) -> str | None:
        """Why an object does not reach its goal even alone, where that is known by now, wherever it stands."""
        return self.hopeless[name][1] if name in self.hopeless else None

    def beyond_hope(self, names: Collection[str]) -> set[str]:
        """Those that are known not to reach their goals even alone, and all whose goals rest on any of them."""
        found, workspace = {name for name in names if name in self.hopeless}, self.asker.workspace
        for name in supports_first(workspace, sorted(names)):
            if found & {*goal_supports(workspace, name)}:
                found.add(name)
        return found

    def against(self, name: str) -> str | None:
        """Why an object does not reach its goal even with all others out of the way; None where it does."""
        if name in self._hopeful:
            return None
        if name in self.hopeless:
            return self.known_against(name)
        workspace = alone(self.asker.workspace, name)
        solution = self.asker.ask(workspace, ALONE, {name, *supports_in_the_way(workspace, name)})
        if solution.plan is not None or self._regrasp_helps(name):
            self._hopeful.add(name)
            return None
        why = f"even alone: {reason(solution)}"
        if not self.asker.late:
            self.hopeless[name] = workspace.start[name], why
        return why

    def _regrasp_helps(self, name: str) -> bool:
        """Whether an object reaches its goal alone by way of another grasp; remembered, for all further tries."""
        workspace = alone(self.asker.workspace, name)
        # Wherever what lies flat is put down in between, no hand takes it up again.
        able = name in workspace.goals and not lies_flat(workspace, name)
        movable = {name, *supports_in_the_way(workspace, name)}
        if able and self.asker.ask(workspace, ALONE, movable, regrasped={name}).plan is not None:
            self.regrasped.add(name)
        return name in self.regrasped
