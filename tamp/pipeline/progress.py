"""A plan in the making: what it does so far, checked piece by piece, and where everything stands after that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from tamp.checking import Verdict, check
from tamp.domains.tabletop import NotFree
from tamp.pipeline.aftermath import after, begins_at
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
        pieces: each as a plan of its own, as the checker has accepted it.
    """

    now: Attempt
    actions: list[Action] = field(default_factory=list)
    rejections: list[str] = field(default_factory=list)
    blocked: list[str] = field(default_factory=list)
    before: list[tuple[int, Attempt]] = field(default_factory=list)
    pieces: list[Plan] = field(default_factory=list)

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
        self.before.append((len(self.actions), self.now))
        self.pieces.append(piece)
        self.actions += piece.actions
        start, configuration = _after(self.start, self.now.configuration, solution)
        workspace = replace(self.now.workspace, start=start)
        self.now = replace(self.now, workspace=workspace, configuration=configuration)
        return None

    def checked(self, plan: Plan) -> Verdict | None:
        """The checker's word on a plan that joins the pieces; None where one does not begin where the last one ends.

        It has accepted every action from the state that those before it leave: only the goals are left to judge.
        """
        state, actions = replace(plan, actions=()), list[Action]()
        for piece in self.pieces:
            if not begins_at(piece, state):
                return None
            actions += piece.actions
            state = replace(after(self.now.setup.world.robot, piece), goals=plan.goals)
        if [id(action) for action in actions] != [id(action) for action in plan.actions]:
            return None
        return check(self.now.setup.task, state, start=state.start, goals=plan.goals)

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
        del self.pieces[len(self.before) :]


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
