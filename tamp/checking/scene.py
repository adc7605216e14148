"""The scene a plan is replayed in: solids of task and robot, and the state that steps change."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import Solid
from tamp.checking.robot.links import Links, read_links
from tamp.task.mesh.parts import parts
from tamp.task.model import TABLE_FRICTION, Box
from tamp.task.robots import task_robot

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray

    from tamp.checking.physics.contacts import Patch
    from tamp.task.mesh.parts import Part
    from tamp.task.model import Region, Task
    from tamp.task.plan import Attachment

    Array = NDArray[np.float64]

GRAVITY = 9.81  # [m/s^2]
TABLE = "table"
ROBOT = "robot"


@dataclass(frozen=True, eq=False)
class Scene:
    """What never changes during a plan.

    Attributes:
        task: the task.
        links: the robot's links.
        solids: name -> solid of each object, and of the table.
        T_world_table: where the table's box stands.
    """

    task: Task
    links: Links
    solids: Mapping[str, Solid]
    T_world_table: Array

    @staticmethod
    def of(task: Task) -> Scene:
        """The scene of a task; TaskError or RobotError where a mesh or the robot cannot be used."""
        table = task.table
        solids = {o.name: _solid(o.name, parts(o.shape)) for o in task.objects}
        solids[TABLE] = _solid(TABLE, parts(Box((*table.size, table.thickness))))
        T = np.eye(4)
        T[:3, 3] = (*table.center, -table.thickness / 2)
        return Scene(task, read_links(task_robot(task)), solids, T)

    def displacement(self, name: str, A: Array, B: Array) -> float:
        """Mean distance of the corners of a cube round an object's middle between two poses [m].

        The cube has the edge of the score's, (length + width + height) / 3. That one's centre is the object's origin
        (see `error`), which may be far from all of it: a turn about there takes the object far and its origin nowhere.
        """
        solid = self.solids[name]
        middle = np.eye(4)
        middle[:3, 3] = (solid.lower + solid.upper) / 2
        return self.error(name, A @ middle, B @ middle)

    def error(self, name: str, A: Array, B: Array) -> float:
        """The same of the score's own cube, whose centre is the object's origin (OCRTOC paper, EDE)."""
        solid = self.solids[name]
        half = float((solid.upper - solid.lower).mean()) / 2
        corners = half * np.array([[x, y, z, 0.0] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        corners[:, 3] = 1.0
        return float(np.linalg.norm((corners @ (A - B).T)[:, :3], axis=1).mean())

    def swing(self, name: str, A: Array, B: Array) -> float:
        """How far the turn between two poses takes the farthest point of an object round its middle [m]."""
        solid = self.solids[name]
        arms = solid.hull.part.vertices - (solid.lower + solid.upper) / 2
        return float(np.linalg.norm(arms @ (A - B)[:3, :3].T, axis=1).max())

    def friction(self, name: str) -> float:
        """A body's coefficient of friction; a contact has the product of its two bodies'."""
        return TABLE_FRICTION if name == TABLE else self.task.object(name).friction

    def center_of_mass(self, name: str, T: Array) -> Array:
        """An object's centre of mass in the world, shape (3,), where it stands at T.

        As its task gives it, or else that of a mass spread evenly.
        """
        given = None if name == TABLE else self.task.object(name).inertia
        center = self.solids[name].center_of_mass if given is None else np.array(given.frame.xyz)
        placed: Array = T[:3, :3] @ center + T[:3, 3]
        return placed

    def inertia(self, name: str) -> Array:
        """An object's tensor of inertia about its centre of mass, in its own frame, shape (3, 3) [kg m^2].

        As its task gives it, or else that of a mass spread evenly.
        """
        thing = self.task.object(name)
        if thing.inertia is None:
            return thing.mass * self.solids[name].inertia
        R = thing.inertia.frame.matrix[:3, :3]
        given: Array = R @ np.diag(thing.inertia.moments) @ R.T
        return given


@lru_cache(maxsize=256)
def _solid(name: str, pieces: tuple[Part, ...]) -> Solid:
    """Made once a process: hulls and surface points cost more than the rest of a small plan's check."""
    return Solid.of(name, pieces)


@dataclass(frozen=True, eq=False)
class Given:
    """How an object gave way, by less than counts as moving, when something that held it left, or came to stand on it.

    Attributes:
        pose: where that takes it, T_world_object, shape (4, 4).
        on: the bodies that have carried it since.
    """

    pose: Array
    on: frozenset[str]


@dataclass(frozen=True, eq=False)
class Hold:
    """How the pads hold an object.

    Attributes:
        force: what each finger presses with as it carries it [N].
        slopes: for each pad the way in which it pushes the object out, as long as the tangent of the slope that its rim
            presses on, in the tool frame, shape (3,).
    """

    force: float
    slopes: tuple[Array, Array]


@dataclass
class State:
    """What steps change.

    Attributes:
        poses: object -> T_world_object, shape (4, 4).
        began: object -> where it stood before anything moved; empty where that is not known.
        q: arm configuration [rad].
        opening: distance between the pads [m]; None where nobody knows it until the first motion says it.
        held: what the gripper holds, or None.
        hold: how it holds, or last held, something.
        time: of all motions so far [s].
        jumped: how far each joint jumped in all, within tolerance, where two motions meet [rad].
        strayed: object -> how far it was shifted aside in all, within tolerances, by what nothing explains [m].
        beside: object -> how far aside it may be unsaid: where it stays at the start, or is drawn by closing pads [m].
        stayed: object -> where it stays at the start, though it is said to stand elsewhere, until the hand moves it;
            and where it is once closing pads have turned it, or the plan says that a grip, a release or a push takes it
            aside, or a grip higher, or turns it, which does not; or once it has given way to what has left it, or come.
        turned: object -> how far it was turned as `strayed` [rad].
        nudged: object -> how far it was nudged since the hand last held it [m].
        rubbed: object -> how far in all things have slid on it that pressed on it within tolerance [m].
        pressed: (what moves, whether that is astray, object, and that) -> how it went on, shape (n, 3), and may have
            gone farther as it turned, (n,) [m], while it pressed on the object, as it does to the end of the last
            motion.
        gripped: where what is held was when the fingers closed on it, T_world_object, or None.
        given: object -> how it gave way within tolerance when something left, or came, until the hand moves it.
        follows: object -> where it comes to as soon as the hand, that has taken something from it or put something on
            it, is out of its way, with what that holds.
        came: the objects that `stayed` tells of because they have come so from where they were said to be, and were.
        touching: (a, b) -> their poses when last looked at, and where b touches a; poses are replaced, never changed.
        facts: what else holds, as rules of a domain keep it, such as ("cleaned", "plate").
    """

    poses: dict[str, Array]
    q: Array
    opening: float | None = None
    held: Attachment | None = None
    hold: Hold | None = None
    time: float = 0.0
    facts: set[tuple[str, ...]] = field(default_factory=set)
    jumped: Array = field(default_factory=lambda: np.zeros(1))
    strayed: dict[str, float] = field(default_factory=dict)
    beside: dict[str, float] = field(default_factory=dict)
    stayed: dict[str, Array] = field(default_factory=dict)
    turned: dict[str, float] = field(default_factory=dict)
    nudged: dict[str, float] = field(default_factory=dict)
    rubbed: dict[str, float] = field(default_factory=dict)
    pressed: dict[tuple[str, bool, str, bool], tuple[Array, Array]] = field(default_factory=dict)
    gripped: Array | None = None
    given: dict[str, Given] = field(default_factory=dict)
    follows: dict[str, Array] = field(default_factory=dict)
    came: set[str] = field(default_factory=set)
    began: Mapping[str, Array] = field(default_factory=dict)
    touching: dict[tuple[str, str], tuple[Array, Array, Patch | None]] = field(default_factory=dict, repr=False)

    def aside(self, name: str, under: Iterable[str] = ()) -> float:
        """How far aside an object may be from where it is said to be, by all that nothing explains [m].

        Seen from what is `under` it: that may be as far aside itself, the other way.
        """
        own = self.strayed.get(name, 0.0) + self.beside.get(name, 0.0)
        return own + max((self.aside(other) for other in under), default=0.0)

    def as_stayed(self, *names: str) -> State:
        """The same with all objects, or some of them, where they stay at the start though said to stand elsewhere."""
        moved = {name: T for name, T in self.stayed.items() if name in self.poses and (not names or name in names)}
        return replace(self, poses={**self.poses, **moved}, touching={})

    def unmoved(self, name: str) -> bool:
        """Whether an object stands where it did before anything moved."""
        return name in self.began and np.array_equal(self.began[name], self.poses[name])

    def copy(self) -> State:
        """The same, to be changed by itself; poses, and what else is replaced and never changed, are shared."""
        own = copy(self)
        for key, value in vars(self).items():
            if isinstance(value, set | dict):
                setattr(own, key, value.copy())
        return own

    def without(self, name: str) -> State:
        """The same with an object taken out of it."""
        return replace(self, poses={other: T for other, T in self.poses.items() if other != name})

    def standing(self, scene: Scene) -> dict[str, Array]:
        """T_world_body of all bodies that stand: the table and every object that is not held."""
        held = None if self.held is None else self.held.object
        return {TABLE: scene.T_world_table, **{name: T for name, T in self.poses.items() if name != held}}


def in_region(scene: Scene, state: State, name: str, region: Region) -> bool:
    """Whether the centre of an object's footprint lies in a region of the table."""
    x, y = footprint_center(scene, state.poses[name], name)
    return abs(x - region.center[0]) <= region.size[0] / 2 and abs(y - region.center[1]) <= region.size[1] / 2


def footprint_center(scene: Scene, T: Array, name: str) -> tuple[float, float]:
    """Centre of the box round an object's vertices as seen from above."""
    points = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
    x, y, _ = (points.min(axis=0) + points.max(axis=0)) / 2
    return float(x), float(y)
