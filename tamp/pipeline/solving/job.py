"""A run in the making: its plans so far, the time they took, and what the next search may go on from."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tamp import clock
from tamp.clock import TimeUp, ended_at
from tamp.errors import PlanningFailure
from tamp.execution.log import Execution
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.plan import Planning
from tamp.pipeline.prepare import Setup
from tamp.pipeline.situation import SAME_PLACE
from tamp.pipeline.solving.repair import Resuming
from tamp.pipeline.solving.risk import worth_its_risk
from tamp.pipeline.strategies.known import Known
from tamp.planning import Report
from tamp.scoring import score
from tamp.scoring.ede import ede, mean_edge
from tamp.task import Plan, Pose, SymbolicFact, Task

if TYPE_CHECKING:
    from tamp.pipeline.perceived.run import Perceived

BRIEF = 5.0  # a second search in less than this would find nothing, and be late [s] ...
BRIEFEST = 1.5  # ... but for one of what a deviation has left undone, often a single object [s]
ANOTHER_SEED = 7919  # the seeds of one run's searches differ by this


@dataclass
class Job:
    """A run in the making."""

    task: Task
    seed: int
    limit: float
    settings: Settings
    began: float = field(default_factory=time.monotonic)
    planning_s: float = 0.0
    searches: int = 0
    reports: list[Report] = field(default_factory=list)
    plans: list[Plan] = field(default_factory=list)
    executions: list[Execution] = field(default_factory=list)
    final_poses: dict[str, Pose] = field(default_factory=dict)
    facts: tuple[SymbolicFact, ...] = ()
    failure: PlanningFailure | None = None
    hurried: bool = False
    obstacles: list[str] = field(default_factory=list)
    rejections: list[str] = field(default_factory=list)
    hopeless: dict[str, tuple[Pose, str]] = field(default_factory=dict)
    unturned: dict[str, Pose] = field(default_factory=dict)
    amended: set[str] = field(default_factory=set)
    strategy: str = ""
    words: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    resting: Mapping[str, Pose] = field(default_factory=dict)
    """Where objects with a goal pose come to rest there, which may be elsewhere."""
    perceived: Perceived | None = None

    @contextmanager
    def planning(self) -> Iterator[None]:
        """Counts what happens inside as planning, and ends it with the limit.

        Raises:
            PlanningFailure: where it had to be interrupted.
        """
        began = clock.now()
        try:
            with ended_at(began + self.limit - self.planning_s):
                yield
        except TimeUp as late:
            raise PlanningFailure("timeout", late) from None
        finally:
            self.planning_s += clock.now() - began

    def plan(self, setup: Setup, poses: Mapping[str, Pose], q: tuple[float, ...]) -> bool:
        """Plan from a state at rest; False where there is no plan."""
        tuning = self.settings.tuning
        share = (
            (tuning.last_plan_share if self.unfinished else tuning.next_plan_share)
            if self.plans
            else tuning.first_plan_share
        )
        kept = (1 - share) * (tuning.punctual_share * self.limit - self.planning_s)
        if kept < (BRIEF if not self.plans else BRIEFEST):
            share = 1.0  # what would be kept serves nobody
        try:
            search, found = self._search(setup, poses, q, share)
            # What was kept for later plans serves for this one, where it is enough to begin anew.
            if (
                found is None
                and search.cut_short
                and self.settings.tuning.punctual_share * self.limit - self.planning_s > BRIEF
            ):
                self.rejections += search.rejections
                search, found = self._search(setup, poses, q, 1.0)
        except PlanningFailure as failure:  # no time was left to begin, or it had to be interrupted
            self.failure = failure
            return False
        self.rejections += search.rejections
        if found is None:
            self.failure = PlanningFailure(search.report.status, search.report)
            self.obstacles = [f"{name}: {why}" for name, why in search.left.items()]
            return False
        self.plans.append(found)
        self.hurried = search.cut_short
        return True

    def insist(self, setup: Setup, poses: Mapping[str, Pose], q: tuple[float, ...]) -> bool:
        """Plan again after a search in vain, while time is left: other seeds find other plans.

        Returns:
            Whether a plan was found that moves anything and is worth its risk.
        """
        for _ in range(self.settings.tuning.max_vain_plans):
            proven = self.failure is not None and self.failure.status == "infeasible"
            if proven or self.settings.tuning.punctual_share * self.limit - self.planning_s < BRIEF:
                return False
            self.forget()
            before = len(self.plans)
            if self.plan(setup, poses, q):
                if self.worthwhile(setup):
                    return True
                del self.plans[max(1, before) :]  # nothing to carry out, and nothing new to say
        return False

    def worthwhile(self, setup: Setup) -> bool:
        """Whether there is something in the last plan to carry out, and it is worth its risk."""
        plan = self.plans[-1]
        failing = self.settings.tuning.failing_share
        return bool(plan.actions) and worth_its_risk(self.task, setup.world.robot, plan, failing, self.chance)

    def _search(
        self, setup: Setup, poses: Mapping[str, Pose], q: tuple[float, ...], share: float
    ) -> tuple[Planning, Plan | None]:
        """Search for a plan in a share of the time that is left."""
        self.searches += 1
        with self.planning():
            search = Planning(
                setup,
                poses,
                q,
                # A new search, from a state that chance has brought about or after one in vain, draws other samples.
                seed=self.seed + ANOTHER_SEED * (self.searches - 1),
                deadline=clock.now() + share * (self.settings.tuning.punctual_share * self.limit - self.planning_s),
                settings=self.settings,
                facts=self.facts,
                known=self._known(poses),
            )
            found = search.run()
            self.reports.append(search.report)
            self.hopeless |= search.hopeless
            self.unturned |= search.unturned
            return search, found

    def _known(self, poses: Mapping[str, Pose]) -> Known:
        """What is known of single objects as long as they are about where they were."""
        return Known(
            hopeless={name: why for name, (pose, why) in self.hopeless.items() if self._is_at(name, pose, poses)},
            unturned=[name for name, pose in self.unturned.items() if self._is_at(name, pose, poses)],
            unsteady=self.unsteady,
        )

    @property
    def unsteady(self) -> list[str]:
        """Objects at which executions have stopped more than once."""
        stopped = Counter(execution.deviation.object for execution in self.executions if execution.deviation)
        return [name for name, times in stopped.items() if times > 1]

    def forget(self) -> None:
        """Let the next search try again what single objects did not reach: other seeds draw other samples."""
        self.hopeless.clear()
        self.unturned.clear()

    def _is_at(self, name: str, pose: Pose, poses: Mapping[str, Pose]) -> bool:
        """Whether an object is about where it was; one that nobody sees any more is not."""
        return name in poses and ede(mean_edge(self.task.object(name).shape), pose, poses[name]) < SAME_PLACE

    def keep(self, setup: Setup, execution: Execution) -> bool:
        """Go on with what is still good of the last plan after an execution that stopped; False where nothing is."""
        try:
            with self.planning():
                left = self.settings.tuning.punctual_share * self.limit - self.planning_s
                seed, deadline = self.seed + ANOTHER_SEED * self.searches, clock.now() + left
                resuming = Resuming(setup, self.settings, seed, deadline, self.chance, self.facts)
                rest, amended = resuming.resume(self.plans[-1], execution, self.amended)
        except PlanningFailure as failure:
            self.failure = failure
            return False
        self.amended |= amended
        if rest is not None:
            self.plans.append(rest)
        return rest is not None

    @property
    def chance(self) -> float:
        """That what goes wrong is planned for anew: the more time there is, the surer."""
        return max(0.0, self.settings.tuning.punctual_share - self.planning_s / self.limit)

    @property
    def unfinished(self) -> bool:
        """Whether the last search ran out of time for anything, so that more may bring what its plan leaves."""
        return self.hurried and bool(self.left)

    @property
    def missed(self) -> set[str]:
        """Objects that the last plan was to bring to their goals and that are not there."""
        goals_met = score(self.task, self.final_poses, self.facts).goals_met
        return {name for name, met in goals_met.items() if not met} - self.left.keys()

    def astray(self, setup: Setup) -> set[str]:
        """Those, and the objects that are there only nearly, as far as the last plan could bring them."""
        goals = {name: place.pose for name, place in setup.goals.items()}
        nearly = {
            name
            for name, goal in (goals | dict(self.plans[-1].goals if self.plans else {})).items()
            if ede(mean_edge(self.task.object(name).shape), self.final_poses[name], goal)
            > self.settings.tuning.astray_m
        }
        return (self.missed | nearly) - self.left.keys()

    @property
    def left(self) -> Mapping[str, str]:
        """Objects whose goals the last plan leaves, and why."""
        left: Mapping[str, str] = self.plans[-1].report.get("left", {}) if self.plans else {}
        return left
