"""What is to be done: objects, where they stand, where they should stand, and who moves them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path

from tamp.errors import ModelError
from tamp.frozen import FrozenDict
from tamp.task.pose import Pose, Vector3
from tamp.task.robot import DEFAULT_ROBOT


@dataclass(frozen=True, slots=True)
class Box:
    """A box centred at the object's origin, `size` along x, y, z [m]."""

    size: Vector3

    def __post_init__(self) -> None:
        size = tuple(self.size) if isinstance(self.size, Iterable) else ()
        if len(size) != 3:
            raise ModelError(f"a box needs a size along x, y and z, not {self.size!r}")
        object.__setattr__(self, "size", size)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z, centred at the object's origin [m]."""

    radius: float
    height: float


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere centred at the object's origin [m]."""

    radius: float


@dataclass(frozen=True, slots=True)
class Capsule:
    """A capsule along z, centred at the object's origin; `height` is between the centres of its caps [m]."""

    radius: float
    height: float


@dataclass(frozen=True, slots=True)
class Mesh:
    """A mesh file (OBJ, STL, PLY, DAE) in metres after `scale`; an OBJ's groups are its convex parts.

    One that stands in for a mesh that is missing has no more than its size: what it overlaps with says nothing.
    """

    path: Path
    scale: float = 1.0
    stand_in: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", Path(self.path))


Shape = Box | Cylinder | Sphere | Capsule | Mesh


@dataclass(frozen=True, slots=True)
class At:
    """The object shall stand at a pose in the world frame."""

    pose: Pose

    def __post_init__(self) -> None:
        if not isinstance(self.pose, Pose):
            raise ModelError(f"a goal needs a tamp.Pose, not {self.pose!r}")


@dataclass(frozen=True, slots=True)
class On:
    """The object shall stand on a region or on another object."""

    target: str


@dataclass(frozen=True, slots=True)
class In:
    """The object shall lie inside another object."""

    target: str


Goal = At | On | In


ANY_TURN = 360
"""As the fold of a symmetry: the object looks the same after any turn about that axis."""


@dataclass(frozen=True, slots=True)
class Symmetry:
    """How many turns about each axis of its frame leave an object looking the same: 1 is none, `ANY_TURN` is all."""

    x: int = 1
    y: int = 1
    z: int = 1


ROUNDED = 1.01
"""By how much more, as a factor, a moment of inertia may be said to be than the other two together."""


@dataclass(frozen=True, slots=True)
class Inertia:
    """How an object's mass is spread.

    Attributes:
        frame: centre of mass and principal axes in the object's frame.
        moments: principal moments of inertia about them [kg m^2].

    Raises:
        ModelError: for moments that no body has: each is positive, and no more than the other two together.
    """

    frame: Pose
    moments: Vector3

    def __post_init__(self) -> None:
        if not all(0.0 < value <= ROUNDED * (sum(self.moments) - value) for value in self.moments):
            raise ModelError(
                f"no body has the moments of inertia {self.moments!r}: each is positive, at most the sum of the others"
            )


MOST = 1e6
"""The largest mass [kg] and coefficient of friction; products of what is larger are no numbers any more."""
LIGHTEST = 1e-5
"""The least mass [kg]: a hundredth of a gram; what is lighter no simulator holds between fingers."""


@dataclass(frozen=True, slots=True)
class Object:
    """A rigid thing on the table. Without a goal it must simply not be harmed: it may be moved aside.

    Attributes:
        name: unique in its task.
        shape: its geometry, in its own frame.
        pose: where it stands at the start.
        goal: where it shall be.
        mass: [kg].
        friction: coefficient of lateral friction; a contact has the product of its two bodies'.
        symmetry: what scores that know of symmetry forgive; the default score does not.
        category: what kind of thing it is, such as "cup"; for statistics.
        inertia: as its source gives it; None is a mass spread evenly.
    """

    name: str
    shape: Shape
    pose: Pose
    goal: Goal | None = None
    mass: float = 0.1
    friction: float = 0.5
    symmetry: Symmetry = Symmetry()
    category: str | None = None
    inertia: Inertia | None = None

    def __post_init__(self) -> None:
        for field_name, kind, valid in (
            ("pose", Pose, "tamp.Pose"),
            ("goal", Goal | None, "tamp.At, On, In and None; a goal pose is tamp.At(pose)"),
        ):
            if not isinstance(value := getattr(self, field_name), kind):
                raise ModelError(f"object {self.name}: {value!r} is no {field_name}; valid are {valid}")
        for field_name, least in (("mass", LIGHTEST), ("friction", 0.0)):
            value = getattr(self, field_name)
            if not (isinstance(value, Real) and float(value) > 0.0 and least <= float(value) <= MOST):
                valid = f"positive numbers up to {MOST:g}" + (f", and {least:g} at least" if least else "")
                raise ModelError(f"object {self.name}: {field_name} is {value!r}; valid are {valid}")


@dataclass(frozen=True, slots=True)
class Region:
    """A rectangle on the table top, axis-aligned; centre and size along x, y [m]."""

    name: str
    center: tuple[float, float]
    size: tuple[float, float]


TABLE_FRICTION = 1.0
"""Coefficient of lateral friction of the table top; a contact has the product of its two bodies'."""


@dataclass(frozen=True, slots=True)
class Table:
    """The table's top face at z = 0: a rectangle by centre and size along x, y [m]. Default: OCRTOC 2021's."""

    center: tuple[float, float] = (-0.12, 0.0)
    size: tuple[float, float] = (0.84, 1.2)
    thickness: float = 0.05


@dataclass(frozen=True, slots=True)
class Limits:
    """How long planning [wall seconds] and execution [simulated seconds] may take."""

    planning_s: float = 60.0
    execution_sim_s: float = 600.0


SymbolicFact = tuple[str, ...]
"""A predicate of the task's domain and the names of objects and regions that it is about, such as ("sink", "basin")."""


def _facts(given: Iterable[Iterable[str]], field: str) -> tuple[SymbolicFact, ...]:
    """Facts as tuples, predicates in lower case as PDDL ignores case; ModelError for what are none."""
    facts = []
    for fact in given:
        if isinstance(fact, str) or not (parts := tuple(fact)) or not all(isinstance(part, str) for part in parts):
            valid = f"valid is a predicate with names, as in {field}=(('Cleaned', 'mug'),)"
            raise ModelError(f"{field}: {fact!r} is no fact; {valid}")
        facts.append((parts[0].lower(), *parts[1:]))
    return tuple(facts)


@dataclass(frozen=True)
class Task:
    """A rearrangement task X = {O, C_initial, C_goal} (OCRTOC paper, section III-A).

    World frame: origin at the table's top, x away from the robot, z up; metres, radians, kilograms.

    Attributes:
        name: what results are filed under.
        objects: what lies on the table.
        robot: the name of an installed robot, or the path of a robot.yaml, relative to the folder of `path`.
        regions: named rectangles that goals may refer to.
        table: the table top.
        domain: what it is planned with: a folder in domains/, or "package.module".
        init: symbolic facts of the domain that hold at the start, as (predicate, name, ...), predicates in lower case.
        goal: symbolic facts that shall hold at the end, beside the objects' goals.
        strategy, search, motion_planner, simulator, perceive: how it is planned and carried out, by the names that the
            command line takes; None leaves it to the user and the defaults.
        samplers: stream name -> "package.module:function", replacing the domain's own samplers.
        limits: budgets of planning and execution.
        level: how difficult whoever made the task says it is; rankings have a mean for each.
        path: the file it came from, or None for a task built in code; it decides no equality.
        base: where the robot's base stands; None leaves it where the robot's data says.
        home: the joint positions that the arm starts from [rad]; None leaves them to the robot's data.
    """

    name: str
    objects: tuple[Object, ...]
    robot: str = DEFAULT_ROBOT
    regions: tuple[Region, ...] = ()
    table: Table = Table()
    domain: str = "tabletop"
    init: tuple[SymbolicFact, ...] = ()
    goal: tuple[SymbolicFact, ...] = ()
    strategy: str | None = None
    search: str | None = None
    motion_planner: str | None = None
    simulator: str | None = None
    perceive: str | None = None
    samplers: Mapping[str, str] = field(default_factory=dict)
    limits: Limits = Limits()
    level: int | None = None
    path: Path | None = field(default=None, compare=False)
    base: Pose | None = None
    home: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "objects", tuple(self.objects))
        object.__setattr__(self, "regions", tuple(self.regions))
        for name in ("init", "goal"):
            object.__setattr__(self, name, _facts(getattr(self, name), name))
        object.__setattr__(self, "samplers", FrozenDict(self.samplers))
        if self.home is not None:
            object.__setattr__(self, "home", tuple(map(float, self.home)))

    def object(self, name: str) -> Object:
        """The object called `name`; KeyError with the valid names where there is none."""
        for candidate in self.objects:
            if candidate.name == name:
                return candidate
        raise KeyError(f"no object {name!r}; the task has {', '.join(o.name for o in self.objects)}")
