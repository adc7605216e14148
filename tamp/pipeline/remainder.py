"""What is still good of a plan when an object is off: the errands that are left and that the checker still accepts.

An errand begins and ends with an empty hand. Once one has become wrong, all later ones with the same object are left
out too; where that leaves a gap, the arm finds its way to the next errand anew. Errands at the end that only put
something aside are done where what they serve, which was left out, is worth it and may yet be planned anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking import check
from tamp.domains.tabletop import NotFree, assemble
from tamp.execution.executor import WATCHFUL
from tamp.execution.record import Execution
from tamp.pipeline.aftermath import after
from tamp.pipeline.setup import Setup
from tamp.pipeline.shortfall import shortfall
from tamp.planning import Context, GroundAction
from tamp.planning.context import generator_for
from tamp.streams.motions import plan_free_motion
from tamp.streams.values import Configuration, Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Action, Move, Plan, Pose, Release, Task

if TYPE_CHECKING:
    from numpy.typing import NDArray

SAME_CONFIGURATION = 0.02  # how far the arm may stand from where the next action begins [rad]


def still_good(setup: Setup, plan: Plan, execution: Execution, deadline: float, *, chance: float = 1.0) -> Plan | None:
    """The errands that are left of a plan whose execution stopped, as far as they can be done as planned.

    Args:
        setup: the prepared task.
        plan: the plan.
        execution: how far it came.
        deadline: for new ways between errands, on the clock of time.monotonic [s].
        chance: that what is left out is planned anew, so that what was put aside for it was not in vain.

    Returns:
        A plan from the state as it is, accepted by the checker, that ends with an empty hand; None where nothing is
        left.
    """
    here = rest = remainder(setup, plan, execution)
    kept, lost, stages = list[Action](), set[str](), [(0, here.start)]
    for errand in errands(rest.actions):
        name = errand[-1].arguments[0]
        piece = None if name in lost else _reached(setup, replace(here, actions=errand), deadline)
        if piece is not None and check(setup.task, piece, start=piece.start, goals=piece.goals).executable:
            kept += piece.actions
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
    noted = (deviation for entry in execution.log[-1:] for deviation in entry.deviations)
    off = sorted(deviation.object for deviation in (*noted, *WATCHFUL.compare(here.start, seen, ())))
    start = {**here.start, **{name: seen[name] for name in off}}
    home = here.home if _same(here.home, execution.configuration) else execution.configuration
    return replace(plan, start=start, home=home, actions=plan.actions[count:])


def errands(actions: Iterable[Action]) -> Iterator[tuple[Action, ...]]:
    """Cut actions wherever the hand has let go of an object; what comes after the last time is no errand."""
    begun: list[Action] = []
    for action in actions:
        begun.append(action)
        if any(isinstance(step, Release) or (isinstance(step, Move) and step.pushed) for step in action.steps):
            yield tuple(begun)
            begun = []


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
    workspace = Workspace(setup.task, setup.world, places, {})
    path = next(plan_free_motion(Context(workspace, lambda: rng, deadline, facts), *ends), None)
    try:
        return None if path is None else assemble(workspace, [GroundAction("move-free", (*ends, path))])[0]
    except NotFree:
        return None


def _same(q: Sequence[float] | NDArray[np.float64], other: Sequence[float]) -> bool:
    return bool(np.abs(np.array(q) - other).max() <= SAME_CONFIGURATION)
