"""The simulators by name: those that come with the program, and third parties'.

These are named by an entry point of their package in the group `tamp.simulators`, or as "package.module:Class".

Nothing here loads a physics engine before it is asked for.
"""

from __future__ import annotations

import importlib.util
import inspect
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import cast

from tamp.errors import TampError, TaskError, meant
from tamp.execution.guard import GuardedSimulator
from tamp.execution.renderer import Item, Rasterizer, Renderer, TexturedMesh
from tamp.execution.simulator import Simulator
from tamp.plugins import addresses, imported
from tamp.task import Mesh, Object, Pose, RobotSpec, Table
from tamp.versions import how_to_install


@dataclass(frozen=True)
class Entry:
    """A simulator that comes with the program.

    Attributes:
        address: "package.module:Class" of its class.
        library: the Python package that it needs.
        extra: the extra of this program that installs it, or None where it comes along as far as it has wheels.
    """

    address: str
    library: str
    extra: str | None = None

    @property
    def installed(self) -> bool:
        """Whether its library is there."""
        try:
            return importlib.util.find_spec(self.library) is not None
        except ValueError:  # another thread is about to import it, and has not said yet where it is from
            return self.library in sys.modules
        except ImportError:  # what looks for it refuses it
            return False


SPINNING = 0.3
"""Share of what an object's shape has, filled evenly, that its least moment of inertia must be at least: with less,
things of ten grams shoot out of fingers in PyBullet. All that OCRTOC gives are 0.39 and more."""

RENDERER = "tamp.execution.pybullet.renderer:PyBulletRenderer"
"""What draws pictures."""

RASTERIZER = "tamp.execution.pybullet.rasterizer:PyBulletRasterizer"
"""What draws textured meshes with their depths."""

WHEELS = "pip install pybullet, which has wheels for Python 3.10 and 3.11"
NO_PICTURES = f"pictures are drawn by PyBullet, which is not installed: {WHEELS}"

SIMULATORS: Mapping[str, Entry] = MappingProxyType(
    {
        "pybullet": Entry("tamp.execution.pybullet.simulator:PyBulletSimulator", "pybullet"),
        "mujoco": Entry("tamp.execution.mujoco.simulator:MuJoCoSimulator", "mujoco", "mujoco"),
        "sapien": Entry("tamp.execution.sapien.simulator:SapienSimulator", "sapien", "sapien"),
    }
)


def installed() -> tuple[str, ...]:
    """Names of the simulators whose libraries are there."""
    return tuple(name for name, entry in SIMULATORS.items() if entry.installed)


METHODS = ("__enter__", "__exit__", "step", "pose", "poses", "place", "speeds", "limit_speeds", "touches")
"""Of a simulator's class."""

DEFAULT = next(iter(installed()), "pybullet")
"""The first that is installed: PyBullet, or MuJoCo where that has no wheels."""


def require(name: str) -> None:
    """Refuse a simulator that cannot be had.

    Args:
        name: of one that comes with the program or that an installed package offers, or "package.module:Class".

    Raises:
        TampError: where it is unknown, or its library is not installed; says what is valid, or how to install it.
    """
    if name not in SIMULATORS:
        _checked(_address(name))
        return
    entry = SIMULATORS[name]
    if not entry.installed:
        raise TampError(
            f"simulator {name!r} is not installed: {how_to_install(entry.extra) if entry.extra else WHEELS}"
        )


def make_simulator(
    name: str,
    objects: Iterable[Object],
    poses: Mapping[str, Pose] = MappingProxyType({}),
    *,
    table: Table | None = None,
    robot: RobotSpec | None = None,
    q: Iterable[float] | None = None,
) -> Simulator:
    """A world in a simulator chosen by name; see tamp.execution.simulator for the arguments and what is raised.

    Raises:
        TampError: where there is no such simulator.
        PartError: where a third party's raises or answers wrongly, now or later on.
        TaskError: where an object's moments of inertia are so small that simulators throw it about.
    """
    objects = tuple(map(_bearable, objects))
    engine = load_simulator(name)

    def make() -> Simulator:
        return cast("Simulator", engine(objects, poses, table=table, robot=robot, q=q))

    return make() if name in SIMULATORS else GuardedSimulator(name, make, robot is not None)


def _bearable(item: Object) -> Object:
    """The object, unless any touch would spin it too fast for steps of milliseconds: its mass is all in its middle.

    What stands in for a shape that is not known may be larger than that was: its moments of inertia are raised.
    """
    if item.inertia is None:
        return item
    import numpy as np

    from tamp.world.geometry.object_geometry import load_geometry

    least = SPINNING * item.mass * float(np.linalg.eigvalsh(load_geometry(item.shape).inertia)[0])
    moments = item.inertia.moments
    if min(moments) >= least:
        return item
    if isinstance(item.shape, Mesh) and item.shape.stand_in:
        x, y, z = (max(moment, least) for moment in moments)
        return replace(item, inertia=replace(item.inertia, moments=(x, y, z)))
    raise TaskError(
        f"{item.name}: its least moment of inertia is {min(moments):.1e} kg m^2, which no simulator bears; "
        f"valid is {least:.1e} at least, {SPINNING:g} of what its shape has, filled evenly"
    )


def load_simulator(name: str) -> type:
    """Import the engine of a simulator; its class, whose instances are worlds in it.

    Raises:
        TampError: where there is no such simulator.
    """
    require(name)
    return _class(SIMULATORS[name].address if name in SIMULATORS else _address(name))


def _address(name: str) -> str:
    """The address of a third party's simulator; TampError where there is none."""
    if ":" in name:
        return name
    offered = addresses("simulators")
    if name not in offered:
        known = (*SIMULATORS, *offered)
        valid = f'{meant(name, known)}valid are {", ".join(known)}, and "package.module:Class" for another one'
        raise TampError(f"unknown simulator {name!r}; {valid}")
    return offered[name]


def _checked(address: str) -> None:
    """Refuse a class that is no simulator: it lacks what the protocol has."""
    found = _class(address)
    if lacking := [name for name in METHODS if not callable(getattr(found, name, None))]:
        raise TampError(f"simulator {address!r} lacks {', '.join(lacking)}; tamp.execution.simulator says what they do")
    try:
        inspect.signature(found).bind((), {}, table=None, robot=None, q=None)
    except TypeError as error:
        raise TampError(f"simulator {address!r} must take (objects, poses, *, table, robot, q): {error}") from None


def can_draw() -> bool:
    """Whether what draws pictures is installed."""
    return SIMULATORS["pybullet"].installed


def make_renderer(items: Sequence[Item], robot: RobotSpec | None) -> Renderer:
    """A scene to take pictures of; see tamp.execution.renderer for the arguments and what is raised.

    Raises:
        TampError: where nothing is installed that draws.
    """
    if not can_draw():
        raise TampError(NO_PICTURES)
    return cast("Renderer", _class(RENDERER)(items, robot))


def make_rasterizer(meshes: Sequence[TexturedMesh]) -> Rasterizer:
    """Meshes to take pictures of, with their depths; see tamp.execution.renderer."""
    return cast("Rasterizer", _class(RASTERIZER)(meshes))


def _class(address: str) -> type:
    module, _, attribute = address.partition(":")
    if not (attribute and all(module.split("."))):
        raise TampError(f"simulator {address!r} is not of the form package.module:Class")
    found = getattr(imported(module, f"simulator {address!r}", TampError), attribute, None)
    if found is None:
        raise TampError(f"simulator {address!r}: the module {module!r} has no {attribute!r}")
    if not isinstance(found, type):
        raise TampError(f"simulator {address!r} is no class")
    return found
