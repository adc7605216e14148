"""The robot's links as solids: hulls of the URDF's collision geometry, and which pairs of links may not touch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.geometry.solids import Solid, clearance
from tamp.checking.geometry.transforms import inverse
from tamp.checking.robot.kinematics import KinematicTree, origin, read_kinematics, read_urdf, vector
from tamp.errors import RobotError, TaskError
from tamp.task.mesh.mesh_file import read_mesh
from tamp.task.mesh.parts import Part, convex_hull, parts
from tamp.task.model import Box, Capsule, Cylinder, Sphere

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from numpy.typing import NDArray

    from tamp.task.model import Shape
    from tamp.task.robot import RobotSpec

    Array = NDArray[np.float64]

SAMPLES = 200
ALWAYS = 0.95
"""Links that overlap in more than this share of random configurations touch by construction of their hulls."""


@dataclass(frozen=True, eq=False)
class Links:
    """A robot's collision geometry.

    Attributes:
        tree: its kinematics.
        solids: one for each link with collision geometry, in the URDF's order.
        fixed: names of the links that no arm joint moves: they stand on the table like the base.
        gripper: names of the links rigid with the tool, and of the fingers.
        pairs: pairs of links that may not touch each other.
    """

    tree: KinematicTree
    solids: tuple[Solid, ...]
    fixed: frozenset[str]
    gripper: frozenset[str]
    pairs: tuple[tuple[Solid, Solid], ...]

    @cached_property
    def reach(self) -> float:
        """No point of a link is farther than this from any joint of the arm [m]: the whole chain, stretched out."""
        return max(self.length(solid.name) + solid.reach for solid in self.solids)

    def reach_with(self, solid: Solid, T_tool_solid: Array) -> float:
        """The same where a body is at rest in the tool frame."""
        tool = self.length(self.tree.spec.tool_parent) + float(np.linalg.norm(self.tree.spec.T_parent_tool.xyz))
        return max(self.reach, tool + float(np.linalg.norm(T_tool_solid[:3, 3])) + solid.reach)

    def length(self, link: str) -> float:
        """Distances between the joints from the base to a link, added up; the fingers fully open [m]."""
        above, total = {joint.child: joint for joint in self.tree.joints}, 0.0
        while link in above:
            joint = above[link]
            travel = self.tree.spec.gripper.stroke if joint.kind == "prismatic" else 0.0
            total += float(np.linalg.norm(joint.T_parent_joint[:3, 3])) + travel
            link = joint.parent
        return total


@lru_cache(maxsize=8)
def read_links(spec: RobotSpec) -> Links:
    """The links of a robot; read once a process and robot.

    Raises:
        RobotError: where the URDF or one of its meshes cannot be used.
    """
    tree = read_kinematics(spec)
    solids: list[Solid] = []
    for link in read_urdf(spec).findall("link"):
        name = str(link.get("name"))
        hulls = [_hull(element, spec, name) for element in link.findall("collision")]
        if hulls:
            solids.append(Solid.of(name, hulls))
    above = {solid.name: tree.path_to(solid.name) for solid in solids}
    tool = tree.path_to(spec.tool_parent)
    return Links(
        tree=tree,
        solids=tuple(solids),
        fixed=frozenset(name for name, joints in above.items() if not joints),
        gripper=frozenset(_hand(tree) & {n for n, joints in above.items() if joints == tool}),
        pairs=_pairs(tree, tuple(solids), above),
    )


def _hand(tree: KinematicTree) -> set[str]:
    """The nearest link that carries both tool and fingers, and all that it carries."""
    wanted, link = {tree.spec.tool_parent, *tree.spec.gripper.fingers}, tree.spec.tool_parent
    parent = {joint.child: joint.parent for joint in tree.joints}
    while not wanted <= _beyond(tree, link):
        link = parent[link]
    return _beyond(tree, link)


def _beyond(tree: KinematicTree, link: str) -> set[str]:
    """A link and all that it carries."""
    found = {link}
    for joint in tree.joints:
        if joint.parent in found:
            found.add(joint.child)
    return found


def _pairs(
    tree: KinematicTree, solids: tuple[Solid, ...], above: dict[str, tuple[str, ...]]
) -> tuple[tuple[Solid, Solid], ...]:
    """Pairs of links to check against each other.

    Left out are links that no arm joint moves against each other, links joined by a joint, those that overlap almost
    always, since their hulls meet by construction and not by motion, and those that the robot's file leaves out.
    """
    joined = {frozenset((joint.parent, joint.child)) for joint in tree.joints}
    candidates = [
        (a, b)
        for a, b in combinations(solids, 2)
        if above[a.name] != above[b.name]
        and frozenset((a.name, b.name)) not in joined
        and not tree.spec.may_touch(a.name, b.name)
    ]
    spec, rng = tree.spec, np.random.default_rng(0)
    q = np.vstack([spec.home, rng.uniform(spec.lower, spec.upper, size=(SAMPLES, len(spec.joints)))])
    placed = tree.forward(q, spec.gripper.stroke)
    kept = []
    for a, b in candidates:
        T_a_b = inverse(placed[a.name]) @ placed[b.name]
        apart = np.linalg.norm(T_a_b[:, :3, :3] @ b.center + T_a_b[:, :3, 3] - a.center, axis=1)
        near = apart < a.radius + b.radius
        hits = np.array([n and clearance(a, b, T, np.inf) < 0.0 for T, n in zip(T_a_b, near, strict=True)])
        if hits.mean() < ALWAYS:
            kept.append((a, b))
    return tuple(kept)


def _hull(element: Element, spec: RobotSpec, link: str) -> Part:
    """The convex hull of one <collision>, in the link's frame.

    Hulls, because some robots' collision meshes are inside out or open, and a hull is never smaller than the mesh.
    """
    geometry = element.find("geometry")
    if geometry is None or len(geometry) != 1:
        raise RobotError(f"{spec.urdf}: link {link!r} has a <collision> without exactly one geometry")
    try:
        points = _points(geometry[0], spec)
        T = origin(element, spec)
        return convex_hull(points @ T[:3, :3].T + T[:3, 3])
    except (TaskError, ValueError, TypeError) as error:
        raise RobotError(f"{spec.urdf}: link {link!r}: cannot read its collision geometry: {error}") from error


def _points(shape: Element, spec: RobotSpec) -> Array:
    if shape.tag == "mesh":
        scale = vector(shape, "scale", spec) if shape.get("scale") else 1.0
        return read_mesh(Path(str(shape.get("filename"))), scale).vertices
    primitive: Shape
    if shape.tag == "box":
        primitive = Box(vector(shape, "size", spec))
    elif shape.tag == "cylinder":
        primitive = Cylinder(float(str(shape.get("radius"))), float(str(shape.get("length"))))
    elif shape.tag == "sphere":
        primitive = Sphere(float(str(shape.get("radius"))))
    elif shape.tag == "capsule":
        primitive = Capsule(float(str(shape.get("radius"))), float(str(shape.get("length"))))
    else:
        raise ValueError(f"unknown geometry <{shape.tag}>; valid are mesh, box, cylinder, sphere and capsule")
    return parts(primitive)[0].vertices
