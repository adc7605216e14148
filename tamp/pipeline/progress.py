"""A plan in the making: what it does so far, checked piece by piece, and where everything stands after that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from tamp.checking import Verdict
from tamp.domains.tabletop import NotFree
from tamp.pipeline.attempt import Attempt
from tamp.pipeline.shortfall import shortfall
from tamp.planning import GroundAction
from tamp.streams.values import Configuration, Handling, Placement, Slide
from tamp.task import Action, Plan

WORTH = 0.001  # what pieces at the end of a plan must gain to be carried out [m]


@dataclass
class Progress:
    """What a plan does so far.

    Attributes:
        now: the state it leaves, as something to plan from; its workspace asks for all goals.
        actions: timed, in order; the checker has accepted each piece of them.
        rejections: the verdict on each piece that the checker sent back; each is a bug of the planner's.
        blocked: why pieces never came before the checker: a timed motion came too near to something.
        before: for each piece, how many actions came before it, and the state they leave.
        first: the first piece as a plan, and the checker's word on it.
    """

    now: Attempt
    actions: list[Action] = field(default_factory=list)
    rejections: list[str] = field(default_factory=list)
    blocked: list[str] = field(default_factory=list)
    before: list[tuple[int, Attempt]] = field(default_factory=list)
    first: tuple[Plan, Verdict] | None = None

    @property
    def start(self) -> Mapping[str, Placement]:
        """Object -> where it stands by now."""
        return self.now.workspace.start

    def take(self, solution: Sequence[GroundAction], seed: int) -> str | None:
        """Time a further piece, have it checked and add it; what is wrong with it where it is refused."""
        try:
            piece, verdict = self.now.finish(solution, seed, {})
        except NotFree as reason:
            self.blocked.append(str(reason))
            return str(reason)
        if not verdict.executable:
            self.rejections.append(str(verdict))
            return str(verdict)
        self.first = (piece, verdict) if not self.actions else self.first
        self.before.append((len(self.actions), self.now))
        self.actions += piece.actions
        start, configuration = _after(self.start, self.now.configuration, solution)
        workspace = replace(self.now.workspace, start=start)
        self.now = replace(self.now, workspace=workspace, configuration=configuration)
        return None

    def checked(self, plan: Plan) -> Verdict | None:
        """The checker's word on the whole plan, where it is one piece and has been heard already."""
        if self.first is None:
            return None
        piece, verdict = self.first
        same = [id(action) for action in piece.actions] == [id(action) for action in plan.actions]
        return verdict if same and piece.goals == plan.goals else None

    def cut_back(self) -> None:
        """Drop the pieces at the end that leave the table no better: what they put aside would stay there."""
        kept, now, least = len(self.actions), self.now, _shortfall(self.now)
        for count, state in reversed(self.before):
            missing = _shortfall(state)
            if missing < least + WORTH:
                kept, now, least = count, state, missing
        self.now = now
        del self.actions[kept:]
        self.before = [stage for stage in self.before if stage[0] < kept]


def _shortfall(state: Attempt) -> float:
    return shortfall(state.setup.task, {name: place.pose for name, place in state.workspace.start.items()})


def _after(
    start: Mapping[str, Placement], configuration: Configuration, solution: Sequence[GroundAction]
) -> tuple[dict[str, Placement], Configuration]:
    """Where objects and arm are when a solution that ends with an empty hand has been carried out."""
    placements = dict(start)
    for action in solution:
        handling = action.args[-1]
        if action.name == "move-free":
            configuration = action.args[1]
        elif isinstance(handling, Slide):
            placements[handling.object] = handling.end
            configuration = action.args[-2]
        elif isinstance(handling, Handling) and action.name not in ("pick", "unstack"):
            placements[handling.object] = handling.placement
            configuration = action.args[-3]
    return placements, configuration
