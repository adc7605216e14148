"""Which grasps take an object from where it stands, and which of those put it down at another place.

A short look before the planner is asked: thousands of places can be sieved in the time of a few searches. The planner
then only has to find the way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import islice
from typing import Any

from tamp.planning import Context
from tamp.planning.context import generator_for
from tamp.streams.clearance import hand_hits, opening_for
from tamp.streams.collisions import handling_hits
from tamp.streams.values import Grasp, Placement
from tamp.streams.workspace import Workspace
from tamp.world.scene import Scene

LOOKED_AT = 60  # grasps of an object
KEPT = 24  # of those, that can take it
SERVING = 2  # grasps after which a place needs no more
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
            self.grasps = tuple(islice(self._usable(offered, workspace.start[name]), KEPT))

    def roomy(self, place: Placement) -> tuple[Grasp, ...]:
        """Those of the grasps for whose hand, open and without an arm, there is room at a place."""
        T_world_object, gripper = place.pose.matrix, self._workspace.world.robot.spec.gripper
        return tuple(
            grasp
            for grasp in self.grasps
            if not hand_hits(
                self._workspace,
                T_world_object @ grasp.T_object_tool.matrix,
                opening_for(gripper, grasp),
                self._scene,
            )
        )

    def serving(self, place: Placement) -> tuple[Grasp, ...]:
        """A few of the grasps, best first, that can also put the object down at a place; none where there are none."""
        return tuple(islice(self._usable(self.roomy(place)[:REACHED], place), SERVING))

    def _usable(self, grasps: Iterable[Grasp], place: Placement) -> Iterator[Grasp]:
        """Those of the grasps by which the arm reaches a place without meeting anything."""
        for grasp in grasps:
            context = self._context("inverse-kinematics", (place, grasp))
            found = self._samplers["inverse-kinematics"](context, self._name, place, grasp)
            for _, _, handling in islice(found, 1):
                if not handling_hits(self._workspace, handling, self._others):
                    yield grasp

    def _context(self, stream: str, inputs: tuple[Any, ...]) -> Context:
        keys = (self._name, *map(repr, inputs))
        context = Context(self._workspace, lambda: generator_for(self._seed, stream, keys), self._deadline)
        context.bound = tuple(("AtPose", other, place) for other, place in self._others.items())
        return context
