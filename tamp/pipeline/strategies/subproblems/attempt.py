"""One state to plan from, what the checker knows of it, and how solutions found there become checked plans."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tamp.checking import Verdict
from tamp.checking.scene import State
from tamp.domains.samplers import resolve_samplers
from tamp.domains.skill import Fact, Question
from tamp.pipeline.options.guard import guarded
from tamp.pipeline.options.settings import Samplers
from tamp.pipeline.prepare import Setup
from tamp.planning import GroundAction, Problem
from tamp.streams.affordances.neighbours import company
from tamp.streams.affordances.stable_poses import steady_faces
from tamp.streams.affordances.support import stands_on
from tamp.streams.collisions import overlap
from tamp.streams.values import Configuration, Placement
from tamp.streams.workspace import Workspace
from tamp.task import Plan, Pose

LEVEL = 0.995  # cosine of how far something is tilted at most from how it lies on a plane that lies so on something


class Judged:
    """What the checker knows of a state beyond where things are said to be: shifts so far, and where things may stay.

    It is noted where the check of what led to the state was run, and found out when it is first needed where that
    runs in another process (see `tamp.speculation`).
    """

    def __init__(self, find_out: Callable[[], State | None]) -> None:
        self._find_out, self._known = find_out, list[State | None]()

    def note(self, state: State | None) -> None:
        """Keep what has been found out."""
        self._known = [state]

    @property
    def state(self) -> State | None:
        """None where the scene was seen as it is: then nothing more is known."""
        if not self._known:
            self.note(self._find_out())
        return self._known[0]


@dataclass(frozen=True, eq=False)
class Attempt:
    """One state to plan from, and how a solution found there becomes a checked plan.

    Attributes:
        setup: the prepared task.
        workspace: what stands where, and where it shall stand.
        samplers: one function for each stream.
        configuration: where the arm is; the hand is empty.
        facts: symbolic facts that hold.
        judged: what the checker knows of the state beyond that.
    """

    setup: Setup
    workspace: Workspace
    samplers: Mapping[str, Callable[..., Any]]
    configuration: Configuration
    facts: tuple[Fact, ...] = ()
    judged: Judged = field(default_factory=lambda: Judged(lambda: None))

    @staticmethod
    def of(
        setup: Setup,
        poses: Mapping[str, Pose],
        q: tuple[float, ...],
        samplers: Samplers | None,
        deadline: float = math.inf,
        facts: tuple[Fact, ...] | None = None,
    ) -> Attempt:
        """The attempt from objects at rest at `poses` and an empty hand at arm configuration `q` [rad].

        Symbolic facts are those of the task's start where none are given.
        """
        workspace = setup.observe(poses, deadline)
        own = {**setup.task.samplers, **(samplers or {})}
        functions = guarded(setup.domain, resolve_samplers(setup.domain.samplers, own), own)
        robot = setup.world.robot
        configuration = Configuration(tuple(robot.overshot(np.array(q)).tolist()), robot.spec.gripper.stroke)
        held = setup.task.init if facts is None else facts
        judged = Judged(lambda: setup.begun(poses, q, held))
        return Attempt(setup, workspace, functions, configuration, held, judged)

    def problem(
        self,
        workspace: Workspace,
        samplers: Mapping[str, Callable[..., Any]],
        movable: Container[str] | None = None,
        regrasped: Container[str] = (),
        either: Container[str] = (),
    ) -> Problem:
        """What the planner is asked from here; see `tamp.domains.skill.Question`."""
        question = Question(self.configuration, None, movable, regrasped, self.facts, either)
        return self.setup.domain.problem(workspace, {**self.samplers, **samplers}, question)

    def timed(self, actions: Sequence[GroundAction], seed: int, report: Mapping[str, Any]) -> Plan:
        """The plan that carries a solution out from here.

        Args:
            actions: the planner's ground actions.
            seed: recorded in the plan.
            report: recorded in the plan.

        Raises:
            NotFree: where a timed motion cannot keep clear.
        """
        task, workspace, domain = self.setup.task, self.workspace, self.setup.domain
        timed = domain.timed(workspace, actions, self.setup.settings.tuning.speeds)
        start, goals = poses_of(workspace.start), poses_of(workspace.goals)
        return Plan(task.name, task.robot, seed, start, self.configuration.q, goals, timed, report)

    def stays(self, name: str, place: Placement, arrived: Collection[str] = ()) -> bool:
        """Whether the checker has an object stay that is let go at a place, whoever put it there.

        All others stand as they do here, or at their goals where they have `arrived`, but for those in that place. What
        plainly stands there is not asked about.
        """
        goals = {other: self.workspace.goals[other] for other in {*arrived} & self.workspace.goals.keys()}
        workspace = replace(self.workspace, start={**self.workspace.start, **goals})
        if _plainly_stands(workspace, name, place):
            return True
        beside = [(other, workspace.start[other]) for other in company(workspace, name, place)]
        others = {other: at.pose for other, at in beside if not overlap(workspace, name, place, other, at)}
        poses = {**others, name: place.pose}
        return workspace.cache.value(("stays", name, tuple(poses.items())), lambda: self.setup.stays(name, poses))

    def checked(self, plan: Plan) -> Verdict:
        """The checker's word on a plan that begins here."""
        goals = poses_of(self.workspace.goals)
        return self.setup.check(plan, start=plan.start, goals=goals, facts=self.facts, after=self.judged.state)


def _plainly_stands(workspace: Workspace, name: str, place: Placement) -> bool:
    """Whether an object stands steadily, and is of one piece on such, or level on one other or on the table alone."""
    geometries = workspace.world.geometries
    below = {lower: workspace.start[lower] for lower in place.on if lower in workspace.start}
    if not stands_on(workspace, name, place, below):
        return False
    if all(len(geometries[body].parts) == 1 for body in (name, *below)):
        return True
    up = place.pose.matrix[2, :3]
    return len(place.on) == 1 and any(up @ face[2] > LEVEL for face in steady_faces(geometries[name]))


def poses_of(places: Mapping[str, Placement]) -> dict[str, Pose]:
    """Object -> its pose (world frame), of placements."""
    return {name: place.pose for name, place in places.items()}
