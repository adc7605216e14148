"""Which grasps take an object from where it stands, and which of those put it down at another place.

A short look before the planner is asked: thousands of places can be sieved in the time of a few searches. The planner
then only has to find the way.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.pipeline.situation import raised
from tamp.planning import Context
from tamp.planning.context import generator_for
from tamp.streams.clearance import clear_of_falling, hand_hits, opening_for
from tamp.streams.collisions import handling_hits
from tamp.streams.dropping import drops
from tamp.streams.footing import amid
from tamp.streams.pinches import Pinches
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

LOOKED_AT = 60  # grasps of an object
KEPT = 24  # of those, that can take it
SERVING = 2  # grasps after which a place needs no more
PUT, DROP = "inverse-kinematics", "plan-laying"  # streams that know ways to a place
REACHED = 4  # grasps for which the arm is asked about a place


class Grips:
    """The grasps that can take one object as things stand, by the run's own samplers.

    Args:
        workspace: what stands where; the object may be moved, all others stay.
        name: the object.
        samplers: one function for each stream.
        seed: decides every random choice.
        deadline: on the clock of time.monotonic [s].
    """

    def __init__(
        self, workspace: Workspace, name: str, samplers: Mapping[str, Callable[..., Any]], seed: int, deadline: float
    ) -> None:
        goals = {other: place for other, place in workspace.goals.items() if other != name}
        self._workspace, self._name = replace(workspace, goals=goals), name
        self._samplers, self._seed, self._deadline = samplers, seed, deadline
        self._others = {other: place for other, place in workspace.start.items() if other != name}
        self._scene = Scene(poses={other: place.pose.matrix for other, place in self._others.items()})
        if any(name in place.on for place in self._others.values()):
            self.grasps: tuple[Grasp, ...] = ()
        else:
            offered = islice(samplers["sample-grasp"](self._context("sample-grasp", ()), name), LOOKED_AT)
            taking = (grasp for grasp in offered if self._reaches(PUT, grasp, workspace.start[name]))
            self.grasps = tuple(islice(taking, KEPT))

    def fits(self, R: NDArray[np.float64]) -> bool:
        """Whether there is a grasp whose hand is clear of the table on which the object stands, turned by R (3, 3)."""
        pose = raised(amid(self._workspace, self._name, R)).pose
        return any(self._is_clear(grasp, pose, Scene()) for grasp in self.grasps)

    def roomy(self, place: Placement) -> tuple[Grasp, ...]:
        """Those of the grasps for whose hand, open and without an arm, there is room at a place or to drop it there."""
        above = [fall[0] for fall in drops(self._workspace, self._name, place)]
        loose = clear_of_falling(self._workspace, self._name, _pinches(self.grasps), place.pose)
        poses = [[place.pose, *above] if falls_out else [place.pose] for falls_out in loose]
        return tuple(
            grasp
            for grasp, let_go in zip(self.grasps, poses, strict=True)
            if any(self._is_clear(grasp, pose, self._scene) for pose in let_go)
        )

    def serving(self, place: Placement) -> tuple[Grasp, ...]:
        """A few of the grasps, best first, that can also bring the object to a place; none where there are none."""
        streams = (PUT, DROP) if drops(self._workspace, self._name, place) else (PUT,)
        grasps = self.roomy(place)[:REACHED]
        able = (grasp for grasp in grasps if any(self._reaches(stream, grasp, place) for stream in streams))
        return tuple(islice(able, SERVING))

    def _is_clear(self, grasp: Grasp, pose: Pose, scene: Scene) -> bool:
        opening = opening_for(self._workspace.world.robot.spec.gripper, grasp)
        return not hand_hits(self._workspace, pose.matrix @ grasp.T_object_tool.matrix, opening, scene)

    def _reaches(self, stream: str, grasp: Grasp, place: Placement) -> bool:
        """Whether the first way to a place that a stream knows meets nothing; once time is up no more are asked for."""
        if time.monotonic() >= self._deadline:
            return False
        found = self._samplers[stream](self._context(stream, (place, grasp)), self._name, place, grasp)
        first = next(found, None)
        return first is not None and not handling_hits(self._workspace, first[-1], self._others)

    def _context(self, stream: str, inputs: tuple[Any, ...]) -> Context:
        keys = (self._name, *map(repr, inputs))
        context = Context(self._workspace, lambda: generator_for(self._seed, stream, keys), self._deadline)
        context.bound = tuple(("AtPose", other, place) for other, place in self._others.items())
        return context


def _pinches(grasps: Sequence[Grasp]) -> Pinches:
    T = np.array([grasp.T_object_tool.matrix for grasp in grasps]).reshape(-1, 4, 4)
    widths = np.array([grasp.width for grasp in grasps])
    clearances = np.array([grasp.clearance for grasp in grasps])
    return Pinches(T, widths, np.zeros(len(grasps)), np.zeros(len(grasps)), clearances)
