"""Are the values plausible: right frame, metres, radians? For the values that the tabletop streams hand around."""

from __future__ import annotations

from collections.abc import Iterator
from functools import singledispatch
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.conformance.sampler.arm_scene import arm_checker
from tamp.streams.values import ArmPath, Configuration, Grasp, Handling, Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task.mesh.parts import convex_hull
from tamp.world.geometry.convex_union import separation, solid

if TYPE_CHECKING:
    from numpy.typing import NDArray

BESIDE = 0.001  # an object this far from the room between the pads is not gripped by them [m]
FAR = 1.5  # a placement this far from the table's centre is on no table [m]
FLOATING = 0.02  # an object this high over the table top that says it stands on it hovers [m]
SUNK = 0.005  # an object this deep in the table collides [m]
LIMIT_SLACK = 1e-6  # [rad]
SAME_TOOL = 0.005  # a handling whose tool is this far from its grasp belongs to another frame [m]
OUTSIDE = 0.001  # an object whose middle is this far outside a region is not on it [m]
PENETRATES = 0.001  # an arm this deep in something collides with it [m]
FINELY = 0.01  # paths are looked at in steps of so much [rad]


@singledispatch
def implausible(
    value: object, workspace: Workspace, inputs: tuple[Any, ...], fluents: tuple[Any, ...] = ()
) -> Iterator[str]:
    """Yield a sentence for each thing about an output that cannot be meant; values of other types pass.

    Args:
        value: an output.
        workspace: objects, table and robot.
        inputs: what the sampler was called with; names of objects and regions are strings among them.
        fluents: the facts that it was told.
    """
    yield from ()


@implausible.register
def _(value: Grasp, workspace: Workspace, inputs: tuple[Any, ...], fluents: tuple[Any, ...] = ()) -> Iterator[str]:
    stroke = workspace.world.robot.spec.gripper.stroke
    if not 0.0 <= value.width <= stroke:
        yield f"width is {value.width:g}; the gripper opens 0 to {stroke:g} m"
    if (beside := _beside_pads(value, workspace, inputs[0])) > BESIDE:
        yield (
            f"the pads would close {1000 * beside:.0f} mm beside {inputs[0]}: T_object_tool must be in the object's "
            "own frame, in metres"
        )


def _beside_pads(grasp: Grasp, workspace: Workspace, obj: str) -> float:
    """How far an object is from the room between the pads that shall close on it [m]; negative inside."""
    robot = workspace.world.robot
    closing, approach = np.array(robot.spec.gripper.axis), np.array([0.0, 0.0, 1.0])
    axes = np.array([closing, np.cross(closing, approach), approach])
    half = np.array([max(grasp.width, BESIDE), *robot.spec.gripper.pad[1:]]) / 2
    signs = np.array(list(product((-1.0, 1.0), repeat=3)))
    corners = (signs * half) @ axes + robot.linkage.depth(grasp.width) * approach
    room, thing = solid([convex_hull(corners)]), solid(workspace.world.geometries[obj].parts)
    return separation(thing, room, grasp.T_object_tool.matrix)


@implausible.register
def _(value: Placement, workspace: Workspace, inputs: tuple[Any, ...], fluents: tuple[Any, ...] = ()) -> Iterator[str]:
    unknown = set(value.on) - {TABLE, *workspace.start}
    if unknown or not value.on:
        yield f"on is {value.on}; it must name 'table' or objects of the task"
    center = np.array((*workspace.task.table.center, 0.0))
    away = float(np.linalg.norm(np.array(value.pose.xyz) - center))
    if away > FAR:
        yield f"the pose is {away:.3g} m from the table's centre: it must be in the world frame, in metres"
        return
    lowest = float(_box(workspace, inputs[0], value.pose.matrix)[0][2])
    if lowest < -SUNK:
        yield f"{inputs[0]} would reach {-1000 * lowest:.0f} mm into the table"
    if value.on == (TABLE,) and lowest > FLOATING:
        yield f"{inputs[0]} would hover {1000 * lowest:.0f} mm over the table that it says it stands on"
    yield from _outside(value, workspace, inputs)


def _outside(value: Placement, workspace: Workspace, inputs: tuple[Any, ...]) -> Iterator[str]:
    """That the middle of an object's footprint, by which goals are judged, is not in a region that was asked for."""
    regions = {TABLE, *(region.name for region in workspace.task.regions)}
    lower, upper = _box(workspace, inputs[0], value.pose.matrix)
    for name in [given for given in inputs[1:] if isinstance(given, str) and given in regions]:
        region = workspace.region(name)
        beyond = np.abs((lower + upper)[:2] / 2 - region.center) - np.array(region.size) / 2
        if (farthest := float(beyond.max())) > OUTSIDE:
            yield f"{inputs[0]} would stand {1000 * farthest:.0f} mm outside {name}"


@implausible.register
def _(
    value: Configuration, workspace: Workspace, inputs: tuple[Any, ...], fluents: tuple[Any, ...] = ()
) -> Iterator[str]:
    yield from _within_limits("q", np.atleast_2d(np.asarray(value.q, float)), workspace)
    stroke = workspace.world.robot.spec.gripper.stroke
    if not 0.0 <= value.opening <= stroke + LIMIT_SLACK:
        yield f"opening is {value.opening:g}; the gripper opens 0 to {stroke:g} m"


@implausible.register
def _(value: Handling, workspace: Workspace, inputs: tuple[Any, ...], fluents: tuple[Any, ...] = ()) -> Iterator[str]:
    limits = [s for name in ("approach", "lift") for s in _within_limits(name, getattr(value, name), workspace)]
    yield from limits
    if limits:
        return
    T_meant = value.let_go.matrix @ value.grasp.T_object_tool.matrix
    for name, q in (("approach ends", value.approach[-1]), ("lift begins", value.lift[0])):
        off = float(np.linalg.norm((workspace.world.robot.forward(q) - T_meant)[:3, 3]))
        if off > SAME_TOOL:
            yield f"the {name} {1000 * off:.0f} mm from where the grasp has the tool"


@implausible.register
def _(value: ArmPath, workspace: Workspace, inputs: tuple[Any, ...], fluents: tuple[Any, ...] = ()) -> Iterator[str]:
    limits = list(_within_limits("points", value.points, workspace))
    yield from limits
    if limits:
        return
    checker = arm_checker(workspace, inputs, fluents, margin=-PENETRATES)
    if (contact := checker.first_contact(value.points, FINELY)) is not None:
        yield f"on the path {contact}: it must be clear of all that stands where context.fluents has it"
    ends = [given for given in inputs if isinstance(given, Configuration)]
    if len(ends) != 2:
        return
    for name, point, given in zip(("begins", "ends"), (value.points[0], value.points[-1]), ends, strict=True):
        off = float(np.abs(point - np.asarray(given.q)).max())
        if off > SAME_TOOL:
            yield f"the path {name} {off:.2g} rad from the configuration it was asked for"


def _within_limits(name: str, points: NDArray[np.float64], workspace: Workspace) -> Iterator[str]:
    spec = workspace.world.robot.spec
    points, joints = np.asarray(points, float), len(spec.joints)
    if points.ndim != 2 or points.shape[1] != joints or not len(points):
        yield f"{name} has shape {points.shape}; expected one row of {joints} joints for each point"
    elif not np.isfinite(points).all():
        yield f"{name} holds numbers that are not finite"
    elif (points < np.array(spec.lower) - LIMIT_SLACK).any() or (points > np.array(spec.upper) + LIMIT_SLACK).any():
        degrees = " (radians, not degrees?)" if np.abs(points).max() > 2 * np.pi else ""
        yield f"{name} leaves the joint limits{degrees}"


def _box(workspace: Workspace, name: str, T: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lower and upper corner of an object's bounding box at a pose."""
    points = np.concatenate([part.vertices for part in workspace.world.geometries[name].parts]) @ T[:3, :3].T + T[:3, 3]
    return points.min(axis=0), points.max(axis=0)
