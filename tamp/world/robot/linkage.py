"""How a gripper's joints and pads go with its opening: fingers that slide, or links that swing on arcs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from tamp.errors import RobotError
from tamp.task.robot import Gripper, RobotSpec
from tamp.world.robot.urdf import without_shapes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SAMPLES = 1001
"""Positions of the driver at which the pads are looked at; between them the opening is wrong by 0.1 um at most."""

STEPS = 128
"""Into so many the stroke of links that swing is parted; from one to the next bodies are taken to move straight."""

CLOSED = 0.002
"""Pads that come no nearer to each other than this do not close [m]."""

PARALLEL = 0.05
"""How far pads may turn against the tool on the way from closed to open [rad]."""

ALONG = 0.99
"""Fingers part along the gripper's axis where the cosine of the angle between is no less."""


@dataclass(frozen=True, eq=False)
class Linkage:
    """The gripper's one degree of freedom, told by the distance between the pads.

    Attributes:
        gripper: the gripper.
        openings: between the pads, ascending, shape (n,) [m].
        drivers: where the driver is then, shape (n,) [rad or m].
        depths: where the pads' middle is along the tool's z then, shape (n,) [m].
        grid: openings between which all links move nearly straight, from 0 to the stroke [m].
    """

    gripper: Gripper
    openings: Array
    drivers: Array
    depths: Array
    grid: Array

    @cached_property
    def axes(self) -> Array:
        """The pads' side, closing and approach directions as rows, shape (3, 3), in the tool's frame."""
        closing, approach = np.array(self.gripper.axis), np.array([0.0, 0.0, 1.0])
        return np.stack([np.cross(closing, approach), closing, approach])

    def driver(self, opening: float) -> float:
        """The driver's position at an opening [m]; [rad or m]."""
        return opening / 2 if self.gripper.pads is None else float(np.interp(opening, self.openings, self.drivers))

    def joints(self, opening: float) -> Array:
        """Positions of all joints of the gripper at an opening [m], in its order, shape (k,)."""
        found: Array = self.driver(opening) * np.array(self.gripper.multipliers) + np.array(self.gripper.offsets)
        return found

    def depth(self, openings: Array | float) -> Array:
        """Where the pads' middle is along the tool's z, for each opening [m]; of the same shape [m]."""
        return np.asarray(np.interp(openings, self.openings, self.depths))

    def opening(self, driver: float) -> float:
        """The distance between the pads where the driver is at a position [rad or m]; [m]."""
        if self.gripper.pads is None:
            return 2.0 * driver
        order = np.argsort(self.drivers)
        return float(np.interp(driver, self.drivers[order], self.openings[order]))

    def per_driver(self, opening: float) -> float:
        """How fast the pads part as the driver moves, at an opening [m]; [m/rad or m/m], its sign included."""
        step, least, most = 0.01 * self.gripper.stroke, float(self.openings[0]), float(self.openings[-1])
        opening = min(max(opening, least), most)  # pads may stop short of closing, and go beyond the stroke
        low, high = max(least, opening - step), min(most, opening + step)
        return (high - low) / (self.driver(high) - self.driver(low))


@cache
def linkage(spec: RobotSpec) -> Linkage:
    """The linkage of a robot's gripper.

    Raises:
        RobotError: where the pads do not close, or not along the gripper's axis, or do not part as far as the stroke,
            or turn back on the way.
    """
    gripper, ends = spec.gripper, np.array([0.0, spec.gripper.stroke])
    if gripper.pads is None:
        low, high = gripper.limits
        if gripper.stroke / 2 > high + 1e-6 or low > CLOSED / 2:
            raise RobotError(
                f"robot {spec.name}: a stroke of {gripper.stroke:g} m needs joints that slide from 0 to half of it; "
                f"{gripper.joints[0]} slides from {low:g} to {high:g} m; of others give gripper.pads"
            )
        _check_axis(spec, pad_points(spec, ends / 2))
        return Linkage(gripper, ends, ends / 2, np.zeros(2), ends)
    drivers = np.linspace(*gripper.limits, SAMPLES)
    frames = finger_frames(spec, drivers)
    pads = _pads(gripper, frames)
    _check_axis(spec, pads)
    apart = (pads[:, 1] - pads[:, 0]) @ np.array(gripper.axis)
    apart = apart * np.sign(apart[np.abs(apart).argmax()])
    if apart[0] > apart[-1]:
        drivers, pads, apart = drivers[::-1], pads[::-1], apart[::-1]
        frames = frames[::-1]
    _check(spec, apart)
    _check_parallel(spec, frames[apart <= gripper.stroke])
    return Linkage(gripper, apart, drivers, pads[:, :, 2].mean(axis=1), np.linspace(0.0, gripper.stroke, STEPS + 1))


def _check(spec: RobotSpec, apart: Array) -> None:
    name, stroke = f"robot {spec.name}", spec.gripper.stroke
    if np.ptp(apart) < CLOSED:
        told = 'fingers that move the same way? <mimic multiplier="-1"> in the URDF lets one go the other way'
        raise RobotError(f"{name}: the pads do not part as {spec.gripper.joints[0]} moves; {told}")
    if (np.diff(apart) <= 0.0).any():
        raise RobotError(f"{name}: the pads turn back between the gripper's limits; give limits without that")
    if apart[0] > CLOSED:
        told = "fingers that do not close are not supported; are gripper.pads and gripper.limits right?"
        raise RobotError(f"{name}: the pads come no nearer than {apart[0]:.4f} m to each other; {told}")
    if apart[-1] < stroke - 1e-4:
        raise RobotError(f"{name}: the pads part by {apart[-1]:.4f} m at most, less than the stroke of {stroke:g} m")


def _check_parallel(spec: RobotSpec, frames: Array) -> None:
    """Refuse fingers (n, 2, 4, 4) that turn against the tool on the way from closed to the stroke, as pliers do."""
    turned = np.einsum("nkij,kij->nk", frames[..., :3, :3], frames[0, :, :3, :3])  # traces: 1 + 2 cos of each turn
    turn = float(np.arccos(np.clip((turned.min() - 1) / 2, -1.0, 1.0)))
    if turn > PARALLEL:
        raise RobotError(
            f"robot {spec.name}: the fingers turn by {turn:.2g} rad on the way from closed to open; only pads that "
            "stay parallel are supported: name the links that do, in gripper.fingers, if there are any"
        )


def _check_axis(spec: RobotSpec, pads: Array) -> None:
    """Refuse pads (n, 2, 3) that part across the gripper's axis on the way from one end of the driver to the other."""
    apart = pads[:, 1] - pads[:, 0]
    moved = apart[-1] - apart[0]
    length = float(np.linalg.norm(moved))
    if length > CLOSED and abs(moved @ np.array(spec.gripper.axis)) < ALONG * length:
        forwards = moved * np.sign(moved[np.abs(moved).argmax()]) / length
        axis, way = (", ".join(f"{v:g}" for v in np.round(w, 2) + 0.0) for w in (spec.gripper.axis, forwards))
        raise RobotError(
            f"robot {spec.name}: the fingers do not close along gripper.axis, [{axis}] in the tool frame, but along "
            f"[{way}]; change gripper.axis, or turn the tool"
        )


def pad_points(spec: RobotSpec, drivers: Array) -> Array:
    """The middles of both pads in the tool frame for positions of the driver (n,); shape (n, 2, 3) [m].

    Where the file names no pads, the origins of the fingers' links stand for them.
    """
    return _pads(spec.gripper, finger_frames(spec, drivers))


def _pads(gripper: Gripper, frames: Array) -> Array:
    pads = np.array(gripper.pads or np.zeros((2, 3)))
    found: Array = np.einsum("nkij,kj->nki", frames[..., :3, :3], pads) + frames[..., :3, 3]
    return found


def finger_frames(spec: RobotSpec, drivers: Array) -> Array:
    """`T_tool_finger` of both fingers for positions of the driver (n,); shape (n, 2, 4, 4)."""
    gripper = spec.gripper
    model = pin.buildModelFromXML(without_shapes(spec.description))
    data, q = model.createData(), pin.neutral(model)
    frames = [model.getFrameId(name) for name in (spec.tool_parent, *gripper.fingers)]
    index = [model.joints[model.getJointId(name)].idx_q for name in gripper.joints]
    found = np.empty((len(drivers), 2, 4, 4))
    for i, driver in enumerate(drivers):
        q[index] = driver * np.array(gripper.multipliers) + np.array(gripper.offsets)
        pin.framesForwardKinematics(model, data, q)
        T_tool_world = (data.oMf[frames[0]] * pin.SE3(spec.T_parent_tool.matrix)).inverse()
        found[i] = [(T_tool_world * data.oMf[frame]).homogeneous for frame in frames[1:]]
    return found


def pad_rates(spec: RobotSpec, drivers: Array) -> Array:
    """How fast the pads part as each joint of the gripper moves alone, for positions of the driver (n,).

    Returns:
        Shape (n, k) [m/rad or m/m], positive where they part.
    """
    gripper = spec.gripper
    model = pin.buildModelFromXML(without_shapes(spec.description))
    data, q = model.createData(), pin.neutral(model)
    tool, *fingers = (model.getFrameId(name) for name in (spec.tool_parent, *gripper.fingers))
    joints = [model.joints[model.getJointId(name)] for name in gripper.joints]
    columns, multipliers = [joint.idx_v for joint in joints], np.array(gripper.multipliers)
    found, aligned = np.zeros((len(drivers), len(joints))), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    for i, driver in enumerate(drivers):
        q[[joint.idx_q for joint in joints]] = driver * multipliers + np.array(gripper.offsets)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        axis = (data.oMf[tool] * pin.SE3(spec.T_parent_tool.matrix)).rotation @ np.array(gripper.axis)
        for way, frame, pad in zip((-1.0, 1.0), fingers, gripper.pads or np.zeros((2, 3)), strict=True):
            J = pin.getFrameJacobian(model, data, frame, aligned)[:, columns]
            arm = data.oMf[frame].rotation @ np.array(pad)
            found[i] += way * (axis @ J[:3] + np.cross(arm, axis) @ J[3:])
    opened = linkage(spec)
    parting = opened.per_driver(gripper.stroke / 2) * float(found[len(found) // 2] @ multipliers)
    return found if parting > 0 else -found
