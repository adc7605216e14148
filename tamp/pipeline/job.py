"""A run in the making: its plans, its executions and its clock."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from tamp.errors import PlanningFailure
from tamp.execution.record import Execution
from tamp.pipeline.amends import Resuming
from tamp.pipeline.attempt import Samplers
from tamp.pipeline.planning import Planning
from tamp.pipeline.setup import Setup
from tamp.pipeline.situation import SAME_PLACE
from tamp.scoring import score
from tamp.scoring.ede import ede, mean_edge
from tamp.task import Plan, Pose, Task

FIRST_SHARE = 0.7  # of the time for planning goes to the first plan at most
NEXT_SHARE = 0.5  # of the time that is left goes to each further one
LAST_SHARE = 0.75  # of it goes to one for what a plan has left for want of time
PUNCTUAL = 0.95  # share of the limit that is given out: whoever is in the middle of something looks at the clock late
BRIEF = 5.0  # a second search in less than this would find nothing, and be late [s]
ANOTHER_SEED = 7919  # the seeds of one run's searches differ by this
ASTRAY = 0.01  # an object that ends farther from its settled goal (EDE) than this is corrected [m]


@dataclass
class Job:
    """A run in the making."""

    task: Task
    seed: int
    limit: float
    samplers: Samplers | None
    algorithm: str
    began: float = field(default_factory=time.monotonic)
    planning_s: float = 0.0
    searches: int = 0
    plans: list[Plan] = field(default_factory=list)
    executions: list[Execution] = field(default_factory=list)
    final_poses: dict[str, Pose] = field(default_factory=dict)
    failure: PlanningFailure | None = None
    hurried: bool = False
    obstacles: list[str] = field(default_factory=list)
    rejections: list[str] = field(default_factory=list)
    hopeless: dict[str, tuple[Pose, str]] = field(default_factory=dict)
    amended: set[str] = field(default_factory=set)

    @contextmanager
    def planning(self) -> Iterator[None]:
        """Counts what happens inside as planning."""
        began = time.monotonic()
        try:
            yield
        finally:
            self.planning_s += time.monotonic() - began

    def plan(self, setup: Setup, poses: Mapping[str, Pose], q: tuple[float, ...]) -> bool:
        """Plan from a state at rest; False where there is no plan."""
        share = (LAST_SHARE if self.unfinished else NEXT_SHARE) if self.plans else FIRST_SHARE
        try:
            search, found = self._search(setup, poses, q, share)
            # What was kept for later plans serves for this one, where it is enough to begin anew.
            if found is None and search.cut_short and PUNCTUAL * self.limit - self.planning_s > BRIEF:
                self.rejections += search.rejections
                search, found = self._search(setup, poses, q, 1.0)
        except PlanningFailure as failure:  # no time was left to begin
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
                deadline=time.monotonic() + share * (PUNCTUAL * self.limit - self.planning_s),
                samplers=self.samplers,
                algorithm=self.algorithm,
                hopeless={name: why for name, (pose, why) in self.hopeless.items() if self._is_at(name, pose, poses)},
            )
            found = search.run()
            self.hopeless |= search.hopeless
            return search, found

    def _is_at(self, name: str, pose: Pose, poses: Mapping[str, Pose]) -> bool:
        return ede(mean_edge(self.task.object(name).shape), pose, poses[name]) < SAME_PLACE

    def keep(self, setup: Setup, execution: Execution) -> bool:
        """Go on with what is still good of the last plan after an execution that stopped; False where nothing is."""
        with self.planning():
            left = PUNCTUAL * self.limit - self.planning_s
            chance = max(0.0, left / self.limit)  # the more time there is, the surer is a new plan for what is off
            seed, deadline = self.seed + ANOTHER_SEED * self.searches, time.monotonic() + left
            resuming = Resuming(setup, self.samplers, self.algorithm, seed, deadline, chance)
            rest, amended = resuming.resume(self.plans[-1], execution, self.amended)
        self.amended |= amended
        if rest is not None:
            self.plans.append(rest)
        return rest is not None

    @property
    def unfinished(self) -> bool:
        """Whether the last search ran out of time for anything, so that more may bring what its plan leaves."""
        return self.hurried and bool(self.left)

    @property
    def missed(self) -> set[str]:
        """Objects that the last plan was to bring to their goals and that are not there."""
        goals_met = score(self.task, self.final_poses).goals_met
        return {name for name, met in goals_met.items() if not met} - self.left.keys()

    def astray(self, setup: Setup) -> set[str]:
        """Those, and the objects that are there only nearly, as far as the last plan could bring them."""
        goals = {name: place.pose for name, place in setup.goals.items()}
        nearly = {
            name
            for name, goal in (goals | dict(self.plans[-1].goals if self.plans else {})).items()
            if ede(mean_edge(self.task.object(name).shape), self.final_poses[name], goal) > ASTRAY
        }
        return (self.missed | nearly) - self.left.keys()

    @property
    def left(self) -> Mapping[str, str]:
        """Objects whose goals the last plan leaves, and why."""
        left: Mapping[str, str] = self.plans[-1].report.get("left", {}) if self.plans else {}
        return left
