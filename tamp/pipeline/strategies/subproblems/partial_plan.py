"""A plan in the making: the pieces so far, the state they lead to, and what refused ones teach."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from tamp.checking import Verdict
from tamp.domains.timing import NotFree
from tamp.errors import PartError
from tamp.pipeline.strategies.subproblems.attempt import Attempt, Judged, poses_of
from tamp.pipeline.strategies.subproblems.plan_state import after, begins_at, ending_with, errands
from tamp.pipeline.strategies.subproblems.rehearsal import WORTH, Astray, rehearsal
from tamp.planning import GroundAction
from tamp.scoring.ede import ede, mean_edge
from tamp.scoring.total_error import shortfall
from tamp.speculation import presumed
from tamp.streams.affordances.falls import learn_jolts, learn_refused, learn_too_high
from tamp.streams.affordances.stack_balance import learn_upset
from tamp.streams.motion.handling_contacts import learn_disturbed, learn_refused_beside
from tamp.streams.pushing.push_motion import learn_refused_push
from tamp.streams.values import Handling, Placement, Slide
from tamp.streams.workspace import Workspace
from tamp.task import Action, Plan, Pose, Release

LEARNED = ("support", "release", "fall", "precondition", "collision", "push")  # problems that are not asked for again
INEXACT = 2  # so often a piece is refused after which an object can be corrected, for one that is more exact
SHIFTED = 0.003  # what stands no farther off (EDE) is where it is said to be, and carries as it shall there [m]


def _learn_met(workspace: Workspace, way: Handling, bodies: Sequence[str], standing: Mapping[str, Placement]) -> None:
    """Let an object not be handled again where one of two bodies meets the other, if one of them stands there.

    What the object meets as it is let go, it meets by whatever grasp; as it is taken, closing pads may have turned it.
    """
    for mover, other in (bodies, bodies[::-1]) if len(bodies) == 2 else ():
        if other == way.object or other not in standing:
            continue
        if mover == way.object:
            learn_disturbed(workspace, way, other, standing[other], by_any_grasp=way.object not in standing)
        else:
            learn_refused_beside(workspace, way, other, standing[other], by_any_grasp=False)


def _learn_fall(workspace: Workspace, way: Handling) -> None:
    """Let what falls to its placement not be let go so again, nor from higher up where it falls straight down."""
    if way.dropped:
        learn_too_high(workspace, way.object, way.placement, way.let_go)
    elif way.laid:
        learn_refused(workspace, way.object, way.placement, way.let_go)


@dataclass(frozen=True)
class Outcome:
    """What came of a further piece.

    Attributes:
        count: how many of its actions are right.
        refused: what is wrong with the rest.
        came: objects that have given way to those, and where they have come to (world frame).
    """

    count: int
    refused: str | None = None
    came: tuple[tuple[str, Pose], ...] = ()


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
        inexact: how often a rehearsal had each object end elsewhere, after which a piece was refused.
        unsteady: objects that did not end where they were put, so that it is rehearsed how they are put anywhere.
    """

    now: Attempt
    actions: list[Action] = field(default_factory=list)
    rejections: list[str] = field(default_factory=list)
    blocked: list[str] = field(default_factory=list)
    before: list[tuple[int, Attempt]] = field(default_factory=list)
    pieces: list[Plan] = field(default_factory=list)
    inexact: Counter[str] = field(default_factory=Counter)
    unsteady: Collection[str] = ()

    @property
    def start(self) -> Mapping[str, Placement]:
        """Object -> where it stands by now."""
        return self.now.workspace.start

    @property
    def shortfall(self) -> float:
        """The errors of all goals that it leaves [m]."""
        return _shortfall(self.now)

    def take(self, solution: Sequence[GroundAction], seed: int, *, near: bool = False) -> str | None:
        """Time a further piece, have it checked and rehearsed, and add it; what is wrong with it where it is refused.

        Where something gives way that it handles later, what comes before that is added all the same.
        `near`: whether it brings something merely near its goal; see `rehearsal`.

        Raises:
            PartError: where a skill and its rule have different facts hold after it.
        """
        try:
            piece = self.now.timed(solution, seed, {})
        except NotFree as reason:
            self.blocked.append(str(reason))
            return str(reason)
        before = self.now
        judged = Judged(lambda: before.checked(piece).state)
        outcome = presumed(lambda: self._judge(piece, solution, near, judged), Outcome(len(piece.actions)))
        if outcome.count == 0:
            return outcome.refused
        solution, domain = solution[: outcome.count], before.setup.domain
        piece = ending_with(replace(piece, actions=piece.actions[: outcome.count]), dict(outcome.came))
        self.before.append((len(self.actions), self.now))
        self.pieces.append(piece)
        self.actions += piece.actions
        facts = domain.facts_after(self.now.facts, piece.actions)
        start, configuration = domain.after(self.start, self.now.configuration, solution)
        start = {**start, **{name: replace(start[name], pose=pose) for name, pose in outcome.came}}
        workspace = replace(self.now.workspace, start=start)
        self.now = replace(self.now, workspace=workspace, configuration=configuration, facts=facts, judged=judged)
        return outcome.refused

    def _judge(self, piece: Plan, solution: Sequence[GroundAction], near: bool, judged: Judged) -> Outcome:
        """How far a further piece holds: by the checker's verdict, and where it goes astray in a simulator.

        What the checker knows after it is noted in `judged`.

        Raises:
            PartError: where a skill and its rule have different facts hold after it.
        """
        part, verdict, refused = piece, self.now.checked(piece), None
        if not verdict.executable or self._handles_astray(piece, verdict):
            shorter, passed = self._while_all_stays(piece)
            if passed is not None:
                part, verdict, refused = shorter, passed, "what gives way is not where the rest was planned from"
        if not verdict.executable:
            self.rejections.append(str(verdict))
            self._learn(verdict, solution)
            return Outcome(0, str(verdict))
        for astray in rehearsal(self.now.setup, part, poses_of(self.start) if near else None, self.unsteady):
            way, tries = solution[astray.action].args[-1], self.inexact[astray.deviation.object]
            many_ways = isinstance(way, Handling) and way.laid
            if astray.correctable and (near or not many_ways or tries >= INEXACT):
                continue
            self.inexact[astray.deviation.object] += 1
            self._learn_astray(astray, solution)
            return Outcome(0, str(astray))
        domain = self.now.setup.domain
        facts = domain.facts_after(self.now.facts, part.actions)
        for fact in sorted(verdict.facts ^ {*facts}):
            sides = ("its rule", "its `facts`") if fact in verdict.facts else ("its `facts`", "its rule")
            told = f"({' '.join(fact)}) holds by {sides[0]} and not by {sides[1]}"
            raise PartError(f"domain {domain.name}: after {part.actions[-1]}, or an action before it, {told}")
        came = self._came(verdict, part)
        judged.note(self.now.checked(ending_with(part, came)).state if came else verdict.state)
        return Outcome(len(part.actions), refused, tuple(came.items()))

    def _handles_astray(self, piece: Plan, verdict: Verdict) -> bool:
        """Whether a piece leaves something that it has handled plainly elsewhere than it says."""
        state, task = verdict.state, self.now.setup.task
        if state is None:
            return False
        handled = {step.object for step in piece.steps if isinstance(step, Release)} & state.stayed.keys()
        said = {name: Pose.from_matrix(state.poses[name]) for name in handled}
        lies = {name: Pose.from_matrix(state.stayed[name]) for name in handled}
        return any(ede(mean_edge(task.object(name).shape), said[name], lies[name]) > SHIFTED for name in handled)

    def _while_all_stays(self, piece: Plan) -> tuple[Plan, Verdict | None]:
        """The errands of a piece up to one to which something gives way that is handled later; with their verdict.

        That is None where there are none. What comes after them was planned from where that stood before.
        """
        done = 0
        for errand in [*errands(piece.actions)][:-1]:
            done += len(errand)
            part = replace(piece, actions=piece.actions[:done])
            verdict = self.now.checked(part)
            later = {name for action in piece.actions[done:] for name in action.arguments}
            if not verdict.executable or not later.isdisjoint(self._came(verdict, part)):
                return part, verdict if verdict.executable else None
        return piece, None

    def _came(self, verdict: Verdict, piece: Plan) -> dict[str, Pose]:
        """Objects that have given way in a piece -> where they have come to; but for what is where it shall be."""
        state, setup = verdict.state, self.now.setup
        if state is None or not state.came:
            return {}
        ends, goals = after(setup.world.robot, piece).start, poses_of(self.now.workspace.goals)
        away = sorted(name for name in state.came if ends[name] != goals.get(name))
        return {name: Pose.from_matrix(state.stayed[name]) for name in away}

    def _learn(self, verdict: Verdict, solution: Sequence[GroundAction]) -> None:
        """Let no question end again with an object put, let fall or taken where the checker says this upsets a pile.

        Nor with one that is handled where it says that what stands there is met, or taken along, nor pushed so again.
        """
        wrong, after = verdict.problems[0], self.now.setup.domain.after
        if wrong.kind not in LEARNED or wrong.action is None:
            return
        last = wrong.action
        before, then = (after(self.start, self.now.configuration, solution[:n])[0] for n in (last, last + 1))
        workspace = replace(self.now.workspace, start=then)
        way = solution[last].args[-1]
        if wrong.kind == "push":
            if isinstance(way, Slide):
                learn_refused_push(workspace, way)
            return
        if wrong.kind == "collision":
            if isinstance(way, Handling):
                _learn_met(workspace, way, wrong.bodies, before)
            return
        if wrong.kind == "precondition":
            for name in before.keys() - then.keys():
                learn_upset(workspace, name, before, put=False)
            return
        for name in then.keys() - before.keys():
            if wrong.kind == "support":
                learn_upset(workspace, name, then)
            elif isinstance(way, Handling):
                _learn_fall(workspace, way)
                if wrong.bodies[:1] != (name,) and not wrong.depth:  # that is no body which it meets on its way down
                    learn_jolts(workspace, name, way.placement, way.let_go)

    def _learn_astray(self, astray: Astray, solution: Sequence[GroundAction]) -> None:
        """Let no question end again with an object let go where a simulator has it come down elsewhere.

        Nor so that it moves another, nor there at all where it moves that far in a few ways, while that one stands so.
        """
        way, off = solution[astray.action].args[-1], astray.deviation
        if not isinstance(way, Handling):
            return
        if off.kind == "misplaced" and off.object == way.object:
            _learn_fall(self.now.workspace, way)
        elif off.kind == "disturbed" and off.object != way.object:
            stands, _ = self.now.setup.domain.after(self.start, self.now.configuration, solution[: astray.action])
            if astray.correctable:
                learn_refused_beside(self.now.workspace, way, off.object, stands[off.object], by_any_grasp=True)
            else:
                learn_disturbed(self.now.workspace, way, off.object, stands[off.object])

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
        now = self.now
        return now.setup.check(state, start=state.start, goals=plan.goals, facts=now.facts, after=now.judged.state)

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
    return shortfall(state.setup.task, poses_of(state.workspace.start))
