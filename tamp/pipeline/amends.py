"""Going on with a plan whose execution stopped, where that helps after putting right what it stopped at.

What later errands count on, such as a bookend between which and another one a book shall stand, is brought to its
place first. That costs one short search, and saves what the plan has taken already.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, replace

from tamp.execution.record import Execution
from tamp.pipeline.asking import Asker
from tamp.pipeline.attempt import Attempt, Samplers
from tamp.pipeline.efforts import EFFORTS
from tamp.pipeline.goals import asking_for
from tamp.pipeline.progress import Progress
from tamp.pipeline.remainder import errands, still_good
from tamp.pipeline.setup import Setup
from tamp.task import Action, Plan


@dataclass(frozen=True)
class Resuming:
    """What it takes to go on with a plan.

    Attributes:
        setup: the prepared task.
        samplers: as for `plan`.
        algorithm: of the stream planner.
        seed: decides every random choice.
        deadline: on the clock of time.monotonic [s].
        chance: that what is left out is planned anew.
    """

    setup: Setup
    samplers: Samplers | None
    algorithm: str
    seed: int
    deadline: float
    chance: float = 1.0

    def resume(self, plan: Plan, execution: Execution, spared: Container[str] = ()) -> tuple[Plan | None, set[str]]:
        """What is still good of a plan whose execution stopped, after putting right what it stopped at if that helps.

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
        kept = still_good(self.setup, plan, execution, self.deadline, chance=self.chance)
        name = "" if execution.deviation is None else execution.deviation.object
        final = name in self.setup.goals and all(errand[-1].arguments[0] != name for errand in rest)
        if _errands(kept) == len(rest) or not final or name in spared:
            return kept, set()
        first = self._amends(plan, execution, name)
        whole = replace(plan, actions=(*plan.actions[:done], *first, *plan.actions[done:]))
        amended = still_good(self.setup, whole, execution, self.deadline, chance=self.chance) if first else None
        return (amended, {name}) if _errands(amended) > 1 + _errands(kept) else (kept, set())

    def _amends(self, plan: Plan, execution: Execution, name: str) -> tuple[Action, ...]:
        """Bring an object to where the plan has it in the end while all else stays; nothing where that fails."""
        poses, q = execution.final_poses, execution.configuration
        attempt = Attempt.of(self.setup, poses, q, self.samplers, self.deadline)
        stay = {other: attempt.workspace.start[other] for other in attempt.workspace.goals}
        goal = replace(self.setup.goals[name], pose=plan.goals[name])
        workspace = replace(attempt.workspace, goals={**stay, name: goal})
        asker = Asker(Progress(replace(attempt, workspace=workspace)), self.seed, self.deadline, self.algorithm)
        solution = asker.ask(asking_for(workspace, {name}), EFFORTS[0].iterations, {name})
        if solution.plan is not None:
            asker.refused(solution.plan)
        return tuple(asker.progress.actions)


def _errands(plan: Plan | None) -> int:
    return 0 if plan is None else sum(1 for _ in errands(plan.actions))
