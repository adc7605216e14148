"""Plan repair: going on with a plan whose execution stopped, after putting right what it stopped at."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.domains.tabletop.skills import MOVE
from tamp.domains.timing import NotFree, Timing
from tamp.execution.executor import WATCHFUL
from tamp.execution.log import Execution
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.prepare import Setup
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.pipeline.strategies.subproblems.goal_graph import asking_for
from tamp.pipeline.strategies.subproblems.partial_plan import Progress
from tamp.pipeline.strategies.subproblems.plan_state import after
from tamp.pipeline.strategies.subproblems.subproblem import EFFORTS, Asker
from tamp.planning import Context, GroundAction
from tamp.planning.context import generator_for
from tamp.scoring.total_error import shortfall
from tamp.streams.motion.paths import plan_free_motion
from tamp.streams.values import Configuration, Placement
from tamp.streams.workspace import TABLE
from tamp.task import Action, Grip, Move, Plan, Pose, Release, SymbolicFact, Task

if TYPE_CHECKING:
    from numpy.typing import NDArray

SAME_CONFIGURATION = 0.02  # how far the arm may stand from where the next action begins [rad]


def still_good(
    setup: Setup,
    plan: Plan,
    execution: Execution,
    deadline: float,
    *,
    chance: float = 1.0,
    facts: tuple[SymbolicFact, ...] = (),
) -> Plan | None:
    """The errands that are left of a plan whose execution stopped, as far as they can be done as planned.

    Args:
        setup: the prepared task.
        plan: the plan.
        execution: how far it came.
        deadline: for new ways between errands, on the clock of tamp.clock.now() [s].
        chance: that what is left out is planned anew, so that what was put aside for it was not in vain.
        facts: the symbolic facts that hold.

    Returns:
        A plan from the state as it is, accepted by the checker, that ends with an empty hand; None where nothing is
        left.
    """
    here = rest = remainder(setup, plan, execution)
    kept, lost, stages = list[Action](), set[str](), [(0, here.start)]
    for errand in errands(rest.actions):
        name = moved(errand)
        piece = None if name in lost else _reached(setup, replace(here, actions=errand), deadline)
        if piece is not None and _executable(setup, piece, facts):
            kept += piece.actions
            facts = setup.domain.facts_after(facts, piece.actions)
            here = after(setup.world.robot, piece)
            stages.append((len(kept), here.start))
        else:
            lost.add(name)
    meant = after(setup.world.robot, rest).start
    count = worth_doing(setup.task, stages, {name: meant[name] for name in sorted(lost)}, chance)
    return replace(rest, actions=tuple(kept[:count])) if count else None


def worth_doing(
    task: Task, stages: Sequence[tuple[int, Mapping[str, Pose]]], lost: Mapping[str, Pose], chance: float
) -> int:
    """How many actions to do: all where what is lost may yet gain what they cost, or else those that leave the best.

    Args:
        task: what is asked for.
        stages: how many actions were done, and where everything stands then; the first before any.
        lost: objects of errands that are left out -> where those would have brought them.
        chance: that this is planned anew.
    """
    missing = [shortfall(task, poses) for _, poses in stages]
    gain = missing[-1] - shortfall(task, {**stages[-1][1], **lost})
    best = missing.index(min(missing))
    return stages[-1 if missing[-1] - missing[best] <= chance * gain else best][0]


def remainder(setup: Setup, plan: Plan, execution: Execution) -> Plan:
    """All of the rest, good or not, from the state as it is.

    What is off is taken as it is seen, everything else as the plan has it: it is there within what executions tolerate.
    """
    count, seen = len(execution.log), execution.final_poses
    here = after(setup.world.robot, replace(plan, actions=plan.actions[:count]))
    noted = [deviation for entry in execution.log[-1:] for deviation in entry.deviations]
    stopped = [] if execution.deviation is None else [execution.deviation]
    off = sorted({deviation.object for deviation in (*noted, *stopped, *WATCHFUL.compare(here.start, seen, ()))})
    start = {**here.start, **{name: seen[name] for name in off}}
    now = tuple(setup.world.robot.overshot(np.array(execution.configuration)).tolist())
    home = here.home if _same(here.home, now) else now
    return replace(plan, start=start, home=home, actions=plan.actions[count:])


def _executable(setup: Setup, piece: Plan, facts: tuple[SymbolicFact, ...]) -> bool:
    return setup.check(piece, start=piece.start, goals=piece.goals, facts=facts).executable


def errands(actions: Iterable[Action]) -> Iterator[tuple[Action, ...]]:
    """Cut actions wherever the hand has let go of an object; what comes after the last time is no errand.

    What the arm takes no part in belongs to the errand before it.
    """
    begun: list[Action] = []
    ended = False
    for action in actions:
        if ended and action.steps:
            yield tuple(begun)
            begun, ended = [], False
        begun.append(action)
        ended = ended or any(
            isinstance(step, Release) or (isinstance(step, Move) and step.pushed) for step in action.steps
        )
    if ended:
        yield tuple(begun)


def moved(errand: Sequence[Action]) -> str:
    """The object that an errand moves."""
    return next(action.arguments[0] for action in reversed(errand) if action.steps)


def _reached(setup: Setup, piece: Plan, deadline: float) -> Plan | None:
    """A plan of one errand, with a new way to it where it does not begin where the arm is; None where none is found."""
    first = next(step for action in piece.actions for step in action.steps)
    if isinstance(first, Move) and _same(first.trajectory.positions[0], piece.home):
        return piece
    deeds = tuple(action for action in piece.actions if action.arguments)  # all but the way to the first of them
    approach = deeds[0].steps[0]
    way = _way(setup, piece, approach, deadline) if isinstance(approach, Move) else None
    return None if way is None else replace(piece, actions=(way, *deeds))


def _way(setup: Setup, piece: Plan, approach: Move, deadline: float) -> Action | None:
    """A motion of the empty hand from where the arm is to where an approach begins."""
    places = {name: Placement(pose, (TABLE,)) for name, pose in sorted(piece.start.items())}
    ends = [
        Configuration(tuple(float(angle) for angle in q), approach.opening)
        for q in (piece.home, approach.trajectory.positions[0])
    ]
    facts = tuple(("AtPose", name, place) for name, place in places.items())
    rng = generator_for(piece.seed, "plan-free-motion", map(repr, ends))
    workspace = setup.workspace(places, {})
    poses = {name: pose.matrix for name, pose in piece.start.items()}
    path = next(plan_free_motion(Context(workspace, lambda: rng, deadline, facts, piece.seed), *ends), None)
    if path is None:
        return None
    timing = Timing(workspace, poses, setup.settings.tuning.speeds)
    try:
        return MOVE.steps(timing, GroundAction("move-free", (*ends, path)))
    except NotFree:
        return None


def _same(q: Sequence[float] | NDArray[np.float64], other: Sequence[float]) -> bool:
    return bool(np.abs(np.array(q) - other).max() <= SAME_CONFIGURATION)


@dataclass(frozen=True)
class Resuming:
    """What it takes to go on with a plan.

    Attributes:
        setup: the prepared task.
        settings: how it is planned.
        seed: decides every random choice.
        deadline: on the clock of tamp.clock.now() [s].
        chance: that what is left out is planned anew.
        facts: the symbolic facts that hold.
    """

    setup: Setup
    settings: Settings
    seed: int
    deadline: float
    chance: float = 1.0
    facts: tuple[SymbolicFact, ...] = ()

    def resume(self, plan: Plan, execution: Execution, spared: Container[str] = ()) -> tuple[Plan | None, set[str]]:
        """What is still good of a plan whose execution stopped, after putting right what it stopped at if that helps.

        What slipped in the hand and was put back is taken up anew; what ended beside its goal is brought there.

        Args:
            plan: the plan.
            execution: how far it came.
            spared: objects that are not put right.

        Returns:
            A plan as `still_good` makes it, None where nothing is left; and what it puts right: that object, where
            errands would be lost without that.
        """
        done = len(execution.log)
        rest = tuple(errands(plan.actions[done:]))
        kept = self._still_good(plan, execution)
        name = "" if execution.deviation is None else execution.deviation.object
        broken = rest[0] if rest and moved(rest[0]) == name and not _grips(rest[0]) else ()
        final = name in self.setup.goals and (bool(broken) or all(moved(errand) != name for errand in rest))
        if _errands(kept) == len(rest) or not final or name in spared:
            return kept, set()
        here = replace(execution, configuration=remainder(self.setup, plan, execution).home)
        first = self._amends(here, name, self._end(plan, done, name, broken))
        actions = (*plan.actions[:done], *first, *plan.actions[done + len(broken) :])
        amended = self._still_good(replace(plan, actions=actions), execution) if first else None
        return (amended, {name}) if _errands(amended) > 1 - bool(broken) + _errands(kept) else (kept, set())

    def _end(self, plan: Plan, done: int, name: str, broken: tuple[Action, ...]) -> Placement:
        """Where to bring an object: to where the errand in which it was lost would have, or else to its goal."""
        if not broken:
            return replace(self.setup.goals[name], pose=plan.goals[name])
        there = after(self.setup.world.robot, replace(plan, actions=plan.actions[: done + len(broken)]))
        return Placement(there.start[name], next(a.arguments[1:] for a in reversed(broken) if a.arguments))

    def _still_good(self, plan: Plan, execution: Execution) -> Plan | None:
        return still_good(self.setup, plan, execution, self.deadline, chance=self.chance, facts=self.facts)

    def _amends(self, execution: Execution, name: str, goal: Placement) -> tuple[Action, ...]:
        """Bring an object to a place while all else stays; nothing where that fails."""
        poses, q = execution.final_poses, execution.configuration
        attempt = Attempt.of(self.setup, poses, q, self.settings.samplers, self.deadline, self.facts)
        stay = {other: attempt.workspace.start[other] for other in attempt.workspace.goals}
        workspace = replace(attempt.workspace, goals={**stay, name: goal})
        asker = Asker(
            Progress(replace(attempt, workspace=workspace)), self.seed, self.deadline, self.settings.algorithm
        )
        solution = asker.ask(asking_for(workspace, {name}), EFFORTS[0].iterations, {name})
        if solution.plan is not None:
            asker.refused(solution.plan)
        return tuple(asker.progress.actions)


def _grips(errand: Sequence[Action]) -> bool:
    return any(isinstance(step, Grip) for action in errand for step in action.steps)


def _errands(plan: Plan | None) -> int:
    return 0 if plan is None else sum(1 for _ in errands(plan.actions))
