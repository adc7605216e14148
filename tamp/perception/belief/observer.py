"""Looking at a scene with a workcell's cameras until what matters is known, or it is not worth another view."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from tamp import clock
from tamp.execution.log import Deviation
from tamp.execution.monitor import deviation
from tamp.execution.recovery import can_carry
from tamp.execution.simulators import DEFAULT
from tamp.perception.belief.absence import absent
from tamp.perception.belief.belief import Belief, nearest_turn, updated
from tamp.perception.belief.next_view import farther_back, next_views, unseen
from tamp.perception.belief.rest import at_rest
from tamp.perception.cameras.camera import Camera, Frame
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.models.object_model import ObjectModel, object_model
from tamp.perception.estimation.tracking.in_hand import estimate_held
from tamp.perception.estimation.tracking.nearby import estimate_nearby
from tamp.perception.evaluation import pose_error
from tamp.perception.perceiver import Perceiver, ask
from tamp.perception.rendering.surface import Surface
from tamp.perception.workcell.measured import with_measured
from tamp.perception.workcell.moving import draw_out, go_to
from tamp.perception.workcell.workcell import Workcell
from tamp.task import Attachment, Pose, Step, Task
from tamp.world.world import World

if TYPE_CHECKING:
    from collections.abc import Iterator

MORE_VIEWS = 4
"""Further views of a scene at most, beyond those of the set-up."""

AT_ONCE = 2
"""Views taken before the perceiver is asked again."""

SURE = 0.5
"""What is known with this confidence is not sought anew, nor worth a further view."""

SAME = 0.02
"""Further views of what was found within this of where it is (EDE over its symmetries) were views of it there [m]."""

MISPLACED = 0.012
"""What is seen farther than this from where it was let go or pushed to (EDE over its symmetries) is misplaced [m].

Glances err by 5 mm, and by 9 seldom."""

GLANCED = 0.8
"""Only a glance of this confidence ends a plan."""


@dataclass
class Observer:
    """Looks at the scene of a workcell.

    Attributes:
        cell: arm and cameras.
        task: objects and table; where the objects stand in it is not looked at.
        looks: object -> what it looks like.
        world: the planner's picture of robot, table and objects.
        perceiver: says where objects are.
        seed: decides every random choice.
        limit_s: no further view is begun after this time in the cell [s].
        simulator: in which estimates settle.
        spent_s: time that the perceiver took so far, on the clock of tamp.clock.now() [s].
    """

    cell: Workcell
    task: Task
    looks: Mapping[str, Surface]
    world: World
    perceiver: Perceiver
    seed: int
    limit_s: float
    simulator: str = DEFAULT
    spent_s: float = field(default=0.0, init=False)
    _count: int = field(default=0, init=False)
    _viewed: dict[str, Pose] = field(default_factory=dict, init=False)

    def look(self, expected: Belief | None = None, wanted: Collection[str] = ()) -> Belief:
        """Look from all viewpoints, then from further ones while what is wanted is unknown or uncertain.

        Args:
            expected: what is believed so far; None is nothing.
            wanted: objects that matter.

        Returns:
            What is believed now, at rest; the arm is clear of it where it can be.
        """
        before = Belief(dict.fromkeys(self.looks, Estimate(None, 0.0))) if expected is None else expected
        frames = list(self._frames(before.poses))
        belief = self._perceived(before, frames, absent(frames, self.looks, before.poses, self.task.table))
        left, sought = MORE_VIEWS, set[str]()
        while left > 0 and (missing := self._missing(belief, wanted)):
            sought |= missing
            taken = list(self._further(belief, frames, missing, min(left, AT_ONCE)))
            if not taken:
                break
            left, frames = left - len(taken), frames + taken
            belief = self._perceived(before, frames, absent(frames, self.looks, before.poses, self.task.table), belief)
        settled = at_rest(self.task, self.world, belief.estimates, self.simulator, before.poses)
        result = Belief(settled, tuple(frames))
        self._viewed |= {name: result.poses[name] for name in sought if name in result.poses}
        # The arm went to its last viewpoint past what was believed then; no plan begins inside what is believed now.
        draw_out(self.cell, self.world, result.poses)
        return result

    def watch(self, expected: Mapping[str, Pose], moved: Collection[str] = ()) -> Deviation | None:
        """A glance by all cameras from where they are: something that is clearly not where it is expected.

        Args:
            expected: object -> where it should be (world frame).
            moved: objects that were just let go of or pushed; they are looked for, around where they should be.
        """
        frames = {camera: self.cell.frame(camera.name) for camera in self.cell.cameras}
        standing = [frame for camera, frame in frames.items() if not camera.viewpoints]
        gone = absent(standing, self.looks, expected, self.task.table)
        if gone:
            return Deviation(min(gone), "disturbed", math.nan, math.nan)
        began = clock.now()
        found = {
            name: estimate_nearby(tuple(frames.values()), self._models, expected, name, self.task.table)
            for name in moved
        }
        self.spent_s += clock.now() - began
        for name, estimate in found.items():
            if estimate.pose is not None and estimate.confidence >= GLANCED:
                beside, _ = pose_error(self._models[name], estimate.pose, expected[name])
                if beside > MISPLACED:
                    turned = nearest_turn(self._models[name], estimate.pose, expected[name])
                    return deviation(name, "misplaced", expected[name], turned)
        return None

    def in_hand(self, held: Attachment, expected: Mapping[str, Pose]) -> Pose | None:
        """Where a held object lies in the tool frame, by what all cameras see from where they are; None: not told."""
        robot = self.world.robot
        tool = Pose.from_matrix(robot.forward(np.array(self.cell.configuration())))
        poses = {**expected, held.object: tool @ held.T_tool_object}
        frames = [self.cell.frame(camera.name) for camera in self.cell.cameras]
        began = clock.now()
        axis = robot.spec.gripper.axis
        found = estimate_held(frames, self._models, poses, held.object, tool, axis, self.task.table)
        self.spent_s += clock.now() - began
        if found.pose is None or found.confidence < SURE:
            return None
        turned = nearest_turn(self._models[held.object], found.pose, poses[held.object])
        return tool.inverse() @ turned

    def can_carry(self, held: Attachment, expected: Mapping[str, Pose], steps: Sequence[Step]) -> bool:
        """Whether a held object, as it lies in the hand, meets nothing that is known until it is let go."""
        return can_carry(self.world, expected, held, steps)

    def _frames(self, poses: Mapping[str, Pose]) -> Iterator[Frame]:
        """What every camera sees from its viewpoints; those that stand look with the arm at home, out of their way.

        What those measure is not driven into: from near it the camera looks from farther back, or not at all. Where
        none stands, those on the arm look from home first, and what they measure from there and from each viewpoint is
        not driven into on the way to the next.
        """
        standing = [camera for camera in self.cell.cameras if not camera.viewpoints]
        go_to(self.cell, self.world, poses, self.cell.robot.home, seed=self._seed())
        frames = [self.cell.frame(camera.name) for camera in standing or self.cell.cameras]
        yield from frames
        world, full = with_measured(self.world, poses, frames, near=not standing)
        for camera in self.cell.cameras:
            for viewpoint in camera.viewpoints:
                behind = farther_back(camera, world, full, viewpoint, np.random.default_rng(self._seed()))
                for q in itertools.chain((viewpoint,), behind):
                    if self.cell.time < self.limit_s and go_to(self.cell, world, full, q, seed=self._seed()):
                        frames.append(self.cell.frame(camera.name))
                        yield frames[-1]
                        if not standing:
                            world, full = with_measured(self.world, poses, frames, near=True)
                        break

    def _perceived(
        self, before: Belief, frames: list[Frame], gone: Collection[str], so_far: Belief | None = None
    ) -> Belief:
        """What is believed with all frames of a look.

        Frames are no new evidence when they are looked at again: it is what was believed before the look that they are
        held against, and what a part of them has said so far counts for what was not known then alone.
        """
        known = before if so_far is None else so_far
        sure = {name: pose for name, pose in known.trusted(SURE).items() if name not in gone}
        expected = {name: e if e.pose is not None else known.estimates[name] for name, e in before.estimates.items()}
        began = clock.now()
        found = ask(self.perceiver, frames, self.looks, table=self.task.table, seed=self._seed(), expected=sure)
        self.spent_s += clock.now() - began
        return Belief(updated(self._models, expected, found, gone), tuple(frames))

    def _missing(self, belief: Belief, wanted: Collection[str]) -> set[str]:
        """What is doubted, but for what stands where further views of it were taken: more would not help."""
        doubted = {name for name in wanted if belief.estimates[name].confidence < SURE}
        return {name for name in doubted if not self._was_viewed(name, belief.estimates[name].pose)}

    def _was_viewed(self, name: str, pose: Pose | None) -> bool:
        """Whether further views were taken of an object where it is said to be."""
        before = self._viewed.get(name)
        return pose is not None and before is not None and pose_error(self._models[name], pose, before)[0] < SAME

    def _further(self, belief: Belief, frames: list[Frame], missing: Collection[str], most: int) -> Iterator[Frame]:
        camera = self._moving
        if camera is None or self.cell.time > self.limit_s:
            return
        rng = np.random.default_rng(self._seed())
        poses = belief.poses
        sought = [np.array(poses[name].xyz) if name in poses else None for name in sorted(missing)]
        hidden = unseen(frames, self.task.table)
        count = 0
        for q in next_views(hidden, camera, self.world, poses, rng, sought=sought):
            if go_to(self.cell, self.world, poses, q, seed=self._seed()):
                count += 1
                yield self.cell.frame(camera.name)
            if count == most:
                return

    @property
    def _moving(self) -> Camera | None:
        """The camera on the arm."""
        return next((camera for camera in self.cell.cameras if camera.viewpoints), None)

    @property
    def _models(self) -> dict[str, ObjectModel]:
        return {name: object_model(surface) for name, surface in self.looks.items()}

    def _seed(self) -> int:
        """A new seed for each question, all of them decided by the first."""
        self._count += 1
        return self.seed * 100_003 + self._count
