"""The world a robot acts in: its geometry once and for all, and the questions that any scene of it may be asked."""

from __future__ import annotations

import copy
from collections.abc import Collection, Iterator, Mapping
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from tamp.task.mesh.parts import parts
from tamp.task.model import Box, Table
from tamp.world.collision.broadphase import Actor, Arena, Setting, hand_actor, hand_configuration, robot_actor
from tamp.world.collision.checker import CollisionChecker
from tamp.world.geometry import convex_union
from tamp.world.geometry.convex_union import Solid, solid
from tamp.world.geometry.object_geometry import Geometry
from tamp.world.motion.planner import PORTFOLIO, MotionCache
from tamp.world.robot.hand import FreeHand
from tamp.world.robot.model import RobotModel
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

TABLE = "table"
ROBOT = "robot"


class World:
    """A robot, a table, and the geometries of the objects that may stand on it. Scenes say where.

    Immutable in meaning: collision structures are built on first use and kept. Belongs to one thread.
    """

    def __init__(
        self,
        robot: RobotModel,
        geometries: Mapping[str, Geometry],
        table: Table | None = None,
        *,
        motion_planner: str = PORTFOLIO,
    ) -> None:
        """`motion_planner`: one of `tamp.world.motion.planner.planner_names()`."""
        self.robot = robot
        self._motion_planner = motion_planner
        self.geometries: Mapping[str, Geometry] = MappingProxyType(dict(sorted(geometries.items())))
        self.table = Table() if table is None else table
        self._solids = {name: solid(geometry.parts) for name, geometry in self.geometries.items()}
        self._table = _table_solid(self.table)
        self._arenas: dict[str | None, Arena] = {}
        self._hand_arenas: dict[str | None, Arena] = {}
        self._hand_setting: tuple[tuple[object, ...], Setting] | None = None

    @cached_property
    def _actor(self) -> Actor:
        return robot_actor(self.robot)

    @cached_property
    def motions(self) -> MotionCache:
        """Motion queries already answered in this world."""
        return MotionCache(planner=self._motion_planner)

    def with_nothing_answered(self) -> World:
        """The same world, collision structures shared, where no motion query has been answered yet."""
        other = copy.copy(self)
        other.__dict__.pop("motions", None)
        return other

    @cached_property
    def _hand(self) -> Actor:
        return hand_actor(self.robot)

    @cached_property
    def _base(self) -> Solid:
        """The links that never move, in the world frame."""
        return solid([body.hull for body in self.robot.bodies if body.joint == 0])

    def checker(
        self,
        scene: Scene,
        *,
        margin: float = 0.005,
        held_margin: float | None = None,
        touch: Mapping[str, float] = MappingProxyType({}),
        held_touch: Mapping[str, float] = MappingProxyType({}),
    ) -> CollisionChecker:
        """The collision check of the robot in a scene.

        Args:
            scene: where objects stand and what the gripper holds.
            margin: least distance of the robot's links to everything [m].
            held_margin: least distance of the held object to everything [m]; default `margin`. A negative one tolerates
                that much penetration, as while lifting from a support or lowering onto it.
            touch: object name (or "table") -> least distance of the robot to it instead of `margin` [m], as for the
                fingers beside an object to be grasped.
            held_touch: the same of the held object instead of `held_margin`, as for what it stands on or leans on.
        """
        held, T_tool_held = scene.held if scene.held is not None else (None, np.eye(4))
        if held not in self._arenas:
            self._arenas[held] = Arena(self._actor, self._table, self._solids, held)
        wide = margin if held_margin is None else held_margin
        setting = Setting(scene.poses, T_tool_held, margin, wide, touch, held_touch)
        return CollisionChecker(self.robot, self._arenas[held], setting, scene.opening)

    def free_hand(self, scene: Scene, margin: float = 0.005, *, ignore: Collection[str] = ()) -> FreeHand:
        """The hand alone among what stands in a scene, for many questions about it; what the scene holds is left out.

        Args:
            scene: where objects stand.
            margin: least distance of hand and fingers to everything [m], 0 or more.
            ignore: objects (or "table") that may be touched.
        """
        standing = [(self._solids[name], T) for name, T in scene.poses.items() if name not in ignore]
        return FreeHand(self.robot, standing if TABLE in ignore else [*standing, self._table], margin)

    def hand_contact(
        self,
        T_world_tool: Matrix,
        opening: float,
        scene: Scene,
        margin: float = 0.005,
        *,
        held_margin: float | None = None,
        ignore: Collection[str] = (),
    ) -> str | None:
        """What the hand alone, without an arm, and what it holds come too close to: an object, "table", or None.

        Args:
            T_world_tool: where the tool is, shape (4, 4).
            opening: distance between the finger pads [m].
            scene: where objects stand and what the gripper holds; its opening plays no role.
            margin: least distance of hand and fingers to everything [m].
            held_margin: least distance of the held object [m]; default `margin`.
            ignore: objects (or "table") that may be touched.
        """
        held = scene.held[0] if scene.held is not None else None
        if held not in self._hand_arenas:
            self._hand_arenas[held] = Arena(self._hand, self._table, self._solids, held)
        arena = self._hand_arenas[held]
        arena.install(self._hand_view(scene, margin, held_margin, tuple(ignore)))
        pair = arena.hit(hand_configuration(self.robot, T_world_tool, opening))
        if pair is None:
            return None
        a, b = arena.pairs[pair]
        return arena.names[a] if b >= len(arena.names) - (held is not None) else arena.names[b]

    def _hand_view(self, scene: Scene, margin: float, held_margin: float | None, ignore: tuple[str, ...]) -> Setting:
        """The setting of a hand query; the last one is kept, as thousands of grasps are asked about one scene."""
        key = (scene, margin, held_margin, ignore)
        if self._hand_setting is None or self._hand_setting[0] != key:
            poses = {name: T for name, T in scene.poses.items() if name not in ignore} if ignore else scene.poses
            touch = {TABLE: -1.0} if TABLE in ignore else {}
            T_tool_held = np.eye(4) if scene.held is None else scene.held[1]
            wide = margin if held_margin is None else held_margin
            self._hand_setting = (key, Setting(poses, T_tool_held, margin, wide, touch))
        return self._hand_setting[1]

    def overlap(self, a: str, T_a: Matrix, b: str, T_b: Matrix | None = None, tolerance: float = 0.003) -> bool:
        """Whether object `a` at `T_a` penetrates `b` by more than `tolerance` [m].

        `b` is an object at `T_b`, or "table", or "robot" for the base links, which stand where they stand.
        """
        other, T_other = self._fixed_or_object(b, T_b)
        return convex_union.overlap(self._solids[a], other, convex_union.relative(T_a, T_other), -tolerance)

    def crossed(self, a: str, T_a: Matrix, b: str, T_b: Matrix) -> bool:
        """Whether a part of object `a` at `T_a` and one of `b` at `T_b` are deep in each other for how thin they are.

        That is by more than a quarter of their thickness together, however little that is.
        """
        return convex_union.crossed(self._solids[a], self._solids[b], convex_union.relative(T_a, T_b))

    def overlapping(
        self, a: str, T: Matrix, b: str, T_b: Matrix | None = None, tolerance: float = 0.003
    ) -> Iterator[int]:
        """Yield in their order which of some poses T of object `a`, shape (n, 4, 4), `overlap` says of."""
        other, T_other = self._fixed_or_object(b, T_b)
        one = self._solids[a]
        for k in convex_union.near(one, T, other, T_other, -tolerance).tolist():
            if convex_union.overlap(one, other, convex_union.relative(T[k], T_other), -tolerance):
                yield k

    def overlaps(self, a: str, T: Matrix, b: str, T_b: Matrix | None = None, tolerance: float = 0.003) -> bool:
        """Whether `overlap` says so of any of some poses T of object `a`, shape (n, 4, 4)."""
        return next(self.overlapping(a, T, b, T_b, tolerance), None) is not None

    def beside(self, a: str, T_a: Matrix, poses: Mapping[str, Matrix], gap: float) -> tuple[str, ...]:
        """Those of other objects, and "table", that object `a` at `T_a` is nearer to than a gap [m], sorted."""
        others = {name: T for name, T in poses.items() if name != a}
        return tuple(sorted(o for o in (TABLE, *others) if self.overlap(a, T_a, o, others.get(o), tolerance=-gap)))

    def separation(self, a: str, T_a: Matrix, b: str, T_b: Matrix | None = None) -> float:
        """Signed distance of object `a` at `T_a` and `b` [m]; negative is the deepest penetration of two parts."""
        other, T_other = self._fixed_or_object(b, T_b)
        return convex_union.separation(self._solids[a], other, convex_union.relative(T_a, T_other))

    def contacts(self, a: str, T_a: Matrix, b: str, T_b: Matrix | None, gap: float) -> tuple[Matrix, Matrix]:
        """Where object `a` at `T_a` and `b` are nearer to each other than a gap [m], one point for each two parts.

        Returns:
            Points on `b` and unit normals from it to `a`, shape (n, 3) each, in the world frame.
        """
        other, T_other = self._fixed_or_object(b, T_b)
        points, normals = convex_union.contacts(self._solids[a], other, convex_union.relative(T_a, T_other), gap)
        return points @ T_a[:3, :3].T + T_a[:3, 3], normals @ T_a[:3, :3].T

    def _fixed_or_object(self, name: str, T: Matrix | None) -> tuple[Solid, Matrix]:
        if T is not None and name in self._solids:
            return self._solids[name], T
        if name == TABLE:
            return self._table
        if name == ROBOT:
            return self._base, np.eye(4)
        raise KeyError(f"no body {name!r} with a pose; there are {', '.join((*self._solids, TABLE, ROBOT))}")


def _table_solid(table: Table) -> tuple[Solid, Matrix]:
    T = np.eye(4)
    T[:3, 3] = (*table.center, -table.thickness / 2)
    return solid(parts(Box((*table.size, table.thickness)))), T
