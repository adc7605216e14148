"""Forward kinematics read from a URDF by the standard library alone, for many configurations at once."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tamp.compiled import compiled
from tamp.errors import RobotError
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.task.robot import RobotSpec

    Array = NDArray[np.float64]


GRIPPER_SAMPLES = 2001
"""Positions of a gripper's driver at which its pads are looked at."""


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint of the URDF: `kind` is the URDF's type, T_parent_joint its place at zero, `axis` in its own frame.

    `effort` is the largest force or torque that its drive bears [N, N m].
    """

    name: str
    kind: str
    parent: str
    child: str
    T_parent_joint: Array
    axis: Array
    effort: float


@dataclass(frozen=True, eq=False)
class KinematicTree:
    """Links and joints of a robot, parents before children.

    Attributes:
        spec: the robot.
        root: name of the base link.
        joints: all joints of the URDF, ordered from the root outwards.
    """

    spec: RobotSpec
    root: str
    joints: tuple[Joint, ...]

    def forward(self, q: Array, opening: float) -> dict[str, Array]:
        """Where all links are.

        Args:
            q: arm configurations, shape (n, joints) [rad].
            opening: distance between the finger pads [m].

        Returns:
            Link name -> T_world_link, shape (n, 4, 4).
        """
        return self._placed(q, np.full(len(q), self._driver(opening)))

    def _placed(self, q: Array, driver: Array) -> dict[str, Array]:
        """Where all links are with the gripper's driver at positions (n,) [rad or m]."""
        gripper = self.spec.gripper
        columns = {name: q[:, i] for i, name in enumerate(self.spec.joints)}
        for name, multiplier, offset in zip(gripper.joints, gripper.multipliers, gripper.offsets, strict=True):
            columns[name] = multiplier * driver + offset
        values = np.zeros((len(self.joints), len(q)))
        for index, joint in enumerate(self.joints):
            if joint.name in columns:
                values[index] = columns[joint.name]
        return dict(zip(self._links, _chained(*self._chain, values), strict=True))

    @cached_property
    def _links(self) -> tuple[str, ...]:
        """The root link, and what each joint carries."""
        return self.root, *(joint.child for joint in self.joints)

    @cached_property
    def _chain(self) -> tuple[Array, NDArray[np.int64], Array]:
        """T_world_root, for each joint its parent's number among the links, and its motion; see `_chained`."""
        number = {link: index for index, link in enumerate(self._links)}
        parents = np.array([number[joint.parent] for joint in self.joints], np.int64)
        return np.array(self.spec.T_world_base.matrix), parents, np.array([_motion(joint) for joint in self.joints])

    def tool(self, q: Array) -> Array:
        """T_world_tool for arm configurations of shape (n, joints); shape (n, 4, 4)."""
        return self.forward(q, 0.0)[self.spec.tool_parent] @ self.spec.T_parent_tool.matrix

    def pad_depth(self, opening: float) -> float:
        """Where the pads' middle is along the tool's z with the pads `opening` [m] apart; [m]."""
        return 0.0 if self.spec.gripper.pads is None else float(np.interp(opening, *self._pads[0::2]))

    def _driver(self, opening: float) -> float:
        """Where the gripper's driver is with the pads `opening` [m] apart; [rad or m]."""
        return opening / 2 if self.spec.gripper.pads is None else float(np.interp(opening, *self._pads[0:2]))

    @cached_property
    def _pads(self) -> tuple[Array, Array, Array]:
        """Openings in ascending order [m], where the driver is then, where the pads' middle is along the tool's z."""
        spec, gripper = self.spec, self.spec.gripper
        driver = np.linspace(*gripper.limits, GRIPPER_SAMPLES)
        placed = self._placed(np.tile(spec.home, (len(driver), 1)), driver)
        T_world_tool = placed[spec.tool_parent] @ spec.T_parent_tool.matrix
        points = [
            (placed[link] @ np.append(pad, 1.0))[:, :3] - T_world_tool[:, :3, 3]
            for link, pad in zip(gripper.fingers, gripper.pads or (), strict=True)
        ]
        first, second = (np.einsum("nji,nj->ni", T_world_tool[:, :3, :3], point) for point in points)
        opening = (second - first) @ np.array(gripper.axis)
        opening = opening * np.sign(opening[np.abs(opening).argmax()])
        order = np.argsort(opening)
        return opening[order], driver[order], ((first + second)[:, 2] / 2)[order]

    def path_to(self, link: str) -> tuple[str, ...]:
        """Names of the arm's joints between the base and a link, outwards."""
        above = {joint.child: joint for joint in self.joints}
        found: list[str] = []
        while link in above:
            if above[link].name in self.spec.joints:
                found.append(above[link].name)
            link = above[link].parent
        return tuple(reversed(found))


def _motion(joint: Joint) -> Array:
    """Matrices A, B, C, D, shape (4, 4, 4), with T_parent_child = A + sin(v) B + (1 - cos(v)) C + v D at a value v.

    Rotations by Rodrigues' formula; a joint that is not moved has v = 0.
    """
    x, y, z = joint.axis
    sine, cosine, value = np.zeros((3, 4, 4))
    if joint.kind == "prismatic":
        value[:3, 3] = joint.axis
    else:
        sine[:3, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        cosine = sine @ sine
    return joint.T_parent_joint @ np.stack([np.eye(4), sine, cosine, value])


@compiled
def _chained(T_root: Array, parents: NDArray[np.int64], motions: Array, values: Array) -> Array:
    """T_world_link of the root and of what each joint carries, shape (joints + 1, n, 4, 4).

    Args:
        T_root: T_world_root, shape (4, 4).
        parents: which link each joint is on, shape (joints,); joint i carries link i + 1.
        motions: as `_motion` gives them, shape (joints, 4, 4, 4).
        values: shape (joints, n) [rad or m].
    """
    joints, n = values.shape
    placed = np.zeros((joints + 1, n, 4, 4))
    placed[0] = T_root
    step = np.empty((4, 4))
    for joint in range(joints):
        A, B, C, D = motions[joint]
        for k in range(n):
            value = values[joint, k]
            sine, cosine = np.sin(value), 1.0 - np.cos(value)
            for i in range(4):
                for j in range(4):
                    step[i, j] = A[i, j] + sine * B[i, j] + cosine * C[i, j] + value * D[i, j]
            above = placed[parents[joint], k]
            for i in range(4):
                for j in range(4):
                    for m in range(4):
                        placed[joint + 1, k, i, j] += above[i, m] * step[m, j]
    return placed


def read_kinematics(spec: RobotSpec) -> KinematicTree:
    """The kinematic tree of a robot's URDF.

    Raises:
        RobotError: where the file is no URDF, or lacks a joint or link that the robot's data names.
    """
    root = read_urdf(spec)
    waiting = [_joint(element, spec) for element in root.findall("joint")]
    children = {joint.child for joint in waiting}
    links = [str(link.get("name")) for link in root.findall("link")]
    roots = [link for link in links if link not in children]
    if len(roots) != 1:
        raise RobotError(f"{spec.urdf}: needs exactly one root link, found {', '.join(roots) or 'none'}")
    known, ordered = {roots[0]}, []
    while waiting:
        ready = [joint for joint in waiting if joint.parent in known]
        if not ready:
            raise RobotError(f"{spec.urdf}: joint {waiting[0].name!r} has no way to the root link {roots[0]!r}")
        ordered += ready
        known |= {joint.child for joint in ready}
        waiting = [joint for joint in waiting if joint not in ready]
    _require({joint.name for joint in ordered}, (*spec.joints, *spec.gripper.joints), "joint", spec)
    _require(known, (spec.tool_parent, *spec.gripper.fingers), "link", spec)
    return KinematicTree(spec, roots[0], tuple(ordered))


def read_urdf(spec: RobotSpec) -> ET.Element:
    """The root element of a robot's URDF; RobotError where it cannot be read."""
    try:
        return ET.fromstring(spec.description)
    except ET.ParseError as error:
        raise RobotError(f"{spec.urdf}: cannot read the URDF: {error}") from error


def origin(element: ET.Element, spec: RobotSpec) -> Array:
    """The transform that an element's <origin> means, shape (4, 4); the identity where it has none."""
    found = element.find("origin")
    if found is None:
        return np.eye(4)
    x, y, z = vector(found, "xyz", spec)
    r, p, w = vector(found, "rpy", spec)
    return Pose.from_rpy((x, y, z), (r, p, w)).matrix


def vector(element: ET.Element, attribute: str, spec: RobotSpec) -> tuple[float, float, float]:
    """Three numbers from an attribute; zeros where it is absent."""
    try:
        a, b, c = (float(word) for word in element.get(attribute, "0 0 0").split())
    except ValueError as error:
        raise RobotError(f"{spec.urdf}: {attribute}={element.get(attribute)!r} are not three numbers") from error
    return a, b, c


def _joint(element: ET.Element, spec: RobotSpec) -> Joint:
    name, kind = str(element.get("name")), str(element.get("type"))
    parent, child, axis = element.find("parent"), element.find("child"), element.find("axis")
    if parent is None or child is None:
        raise RobotError(f"{spec.urdf}: joint {name!r} lacks its parent or child link")
    along = np.array((1.0, 0.0, 0.0) if axis is None else vector(axis, "xyz", spec))
    length = float(np.linalg.norm(along))
    limit = element.find("limit")
    effort = 0.0 if limit is None else float(limit.get("effort", "0"))
    return Joint(
        name=name,
        kind=kind,
        parent=str(parent.get("link")),
        child=str(child.get("link")),
        T_parent_joint=origin(element, spec),
        axis=along / length if length > 0 else along,
        effort=effort if effort > 0.0 else np.inf,
    )


def _require(present: set[str], names: tuple[str, ...], what: str, spec: RobotSpec) -> None:
    for name in names:
        if name not in present:
            raise RobotError(f"{spec.urdf}: no {what} {name!r}, which robot {spec.name!r} names")
