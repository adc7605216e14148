"""URDF files -> one description of the robot: gripper attached, meshes found, only what is driven movable.

URDFs come as ROS has them: `package://` paths, joints that turn without end, wheels, heads and second arms, joints that
mimic others, elements and attributes of other tools. All rooms read the description that is left, and none of that.
"""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import unquote
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from tamp.errors import RobotError
from tamp.task.files.regular_file import read_regular
from tamp.task.files.robot.urdf_grammar import (
    MOVABLE,
    finite,
    require_expanded,
    require_grammar,
    root_links,
    triple,
)
from tamp.task.pose import Pose

MAX_BYTES = 32 * 2**20


@dataclass(frozen=True)
class Attachment:
    """A gripper's own URDF: the link of the arm that carries its root, where, and what its names begin with."""

    urdf: Path
    parent: str
    pose: Pose
    prefix: str


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: multiplier * that one's position + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Driven:
    """What is said of a joint that the robot drives.

    Attributes:
        lower, upper: limits of its position [rad or m].
        effort: the largest torque or force [N m or N].
        velocity: the largest, where the URDF says none [rad/s or m/s].
    """

    lower: float
    upper: float
    effort: float
    velocity: float


@dataclass(frozen=True, eq=False)
class Urdf:
    """What a robot's URDF files say together.

    Attributes:
        path: the arm's file, for messages.
        root: links and joints, with absolute paths of meshes.
    """

    path: Path
    root: Element

    @property
    def joints(self) -> dict[str, Element]:
        """The joints by name."""
        return {joint.get("name", ""): joint for joint in self.root.findall("joint")}

    @property
    def links(self) -> dict[str, Element]:
        """The links by name."""
        return {link.get("name", ""): link for link in self.root.findall("link")}

    def joint(self, name: str) -> Element:
        """The joint called so; RobotError with the movable ones where there is none."""
        if name not in self.joints:
            valid = sorted(n for n, joint in self.joints.items() if joint.get("type") in MOVABLE)
            told = ", ".join(valid) or "none that moves"
            raise RobotError(f"{self.path}: there is no joint {name!r}; the URDF has {told}")
        return self.joints[name]

    def require_link(self, name: str) -> None:
        """RobotError with the links that there are where there is none called so."""
        if name not in self.links:
            raise RobotError(f"{self.path}: there is no link {name!r}; the URDF has {', '.join(sorted(self.links))}")

    def limits(self, name: str, what: str = "lower and upper") -> tuple[float, float] | None:
        """A joint's position limits, None where it turns without end.

        Raises:
            RobotError: where a joint that needs them has none.
        """
        joint = self.joint(name)
        limit = joint.find("limit")
        if joint.get("type") == "continuous":
            return None
        if limit is None or limit.get("lower") is None or limit.get("upper") is None:
            raise RobotError(f"{self.path}: joint {name!r} has no limits; <limit {what}> is needed")
        return finite(limit, "lower", self.path), finite(limit, "upper", self.path)

    def largest(self, name: str, what: Literal["velocity", "effort"]) -> float:
        """A joint's largest velocity or effort; RobotError where the URDF does not say it, or says 0."""
        limit = self.joint(name).find("limit")
        most = 0.0 if limit is None else finite(limit, what, self.path)
        if most <= 0.0:
            raise RobotError(f"{self.path}: joint {name!r} has no {what} limit; give arm.{what} in robot.yaml")
        return most

    def way(self, link: str) -> list[str]:
        """Names of the joints from the root to a link."""
        carrier = {_end(joint, "child"): joint for joint in self.root.findall("joint")}
        found = []
        while link in carrier:
            found.append(carrier[link].get("name", ""))
            link = _end(carrier[link], "parent")
        return found[::-1]

    def mimics(self) -> dict[str, Mimic]:
        """Which joints follow which others, as <mimic> says."""
        found = {}
        for name, joint in self.joints.items():
            mimic = joint.find("mimic")
            if mimic is not None:
                multiplier = finite(mimic, "multiplier", self.path, default=1.0)
                found[name] = Mimic(mimic.get("joint", ""), multiplier, finite(mimic, "offset", self.path))
        return found

    def described(self, driven: Mapping[str, Driven], posture: Mapping[str, float]) -> str:
        """The description: the driven joints with these limits, all others fixed at their posture, or near 0."""
        root = ElementTree.fromstring(ElementTree.tostring(self.root, encoding="unicode"))
        for joint in root.findall("joint"):
            name, kind = joint.get("name", ""), joint.get("type")
            for mimic in joint.findall("mimic"):
                joint.remove(mimic)
            if name in driven:
                _drive(joint, driven[name])
            elif kind in MOVABLE:
                _fix(joint, self.standing(name, posture), self.path)
            elif kind != "fixed":
                joint.set("type", "fixed")
        return ElementTree.tostring(root, encoding="unicode")

    def still(self, driven: Container[str], posture: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
        """The joints that could move and are not driven, and where they stand; those that float stand at 0."""
        return tuple(
            (name, self.standing(name, posture))
            for name, joint in self.joints.items()
            if joint.get("type") != "fixed" and name not in driven
        )

    def standing(self, name: str, posture: Mapping[str, float]) -> float:
        """Where a joint that nothing drives stands: in its posture, or at 0, or at the limit next to it [rad or m]."""
        limit = self.joints[name].find("limit")
        if name in posture or limit is None or self.joints[name].get("type") == "continuous":
            return posture.get(name, 0.0)
        low, high = (finite(limit, end, self.path) for end in ("lower", "upper"))
        return min(max(0.0, low), high)


def _fix(joint: Element, value: float, path: Path) -> None:
    """Let a joint stand still where it is at a value [rad or m]."""
    if value != 0.0:
        axis = joint.find("axis")
        along = (1.0, 0.0, 0.0) if axis is None else triple(axis, "xyz", path, default="1 0 0")
        pose = pose_of(joint, path) @ _moved(along, value, slides=joint.get("type") == "prismatic")
        for origin in joint.findall("origin"):
            joint.remove(origin)
        _place(joint, pose)
    joint.set("type", "fixed")


def read_urdf(path: Path, attachment: Attachment | None, folders: Sequence[Path]) -> Urdf:
    """Read an arm's URDF, and a gripper's into it.

    Args:
        path: the arm's file.
        attachment: the gripper, where it has a file of its own.
        folders: where `package://` paths are looked for.

    Raises:
        RobotError: where a file is missing or no URDF, names clash, or a collision mesh is not found.
    """
    root = _links_and_joints(path, folders)
    if attachment is not None:
        _attach(Urdf(path, root), attachment, folders)
    return Urdf(path, root)


def _attach(arm: Urdf, attachment: Attachment, folders: Sequence[Path]) -> None:
    hand = _links_and_joints(attachment.urdf, folders)
    _rename(hand, attachment.prefix)
    arm.require_link(attachment.parent)
    mine = Urdf(attachment.urdf, hand)
    for what, those, these in (("link", arm.links, mine.links), ("joint", arm.joints, mine.joints)):
        if twice := sorted(those.keys() & these.keys()):
            raise RobotError(
                f"{attachment.urdf}: both arm and gripper have a {what} {twice[0]!r}; give gripper.attach a prefix"
            )
    joint = ElementTree.SubElement(arm.root, "joint", name=f"{attachment.prefix}attached", type="fixed")
    ElementTree.SubElement(joint, "parent", link=attachment.parent)
    ElementTree.SubElement(joint, "child", link=root_links(hand)[0])
    _place(joint, attachment.pose)
    arm.root.extend(list(hand))


def _rename(root: Element, prefix: str) -> None:
    for element in root:
        element.set("name", prefix + element.get("name", ""))
        for reference, attribute in (("parent", "link"), ("child", "link"), ("mimic", "joint")):
            for found in element.findall(reference):
                found.set(attribute, prefix + found.get(attribute, ""))


def _links_and_joints(path: Path, folders: Sequence[Path]) -> Element:
    """A file's links and joints with absolute paths of meshes, and nothing else of it."""
    source = _parse(path)
    require_expanded(source, path)
    root = Element("robot", name=source.get("name", "robot"))
    for tag in ("link", "joint"):
        for element in source.findall(tag):
            _strip(element)
            root.append(element)
    require_grammar(root, path)
    for link in root.findall("link"):
        _weigh(link)
        for kind in ("collision", "visual"):
            for element in link.findall(kind):
                mesh = element.find("geometry/mesh")
                if mesh is None:
                    if kind == "visual" and element.find("geometry/*") is None:
                        link.remove(element)
                    continue
                file, looked = find_mesh(mesh.get("filename", ""), path, folders)
                if file is not None:
                    mesh.set("filename", str(file))
                elif kind == "visual":  # only pictures are the poorer for it
                    link.remove(element)
                else:
                    raise RobotError(
                        f"{path}: link {link.get('name')!r}: there is no mesh {mesh.get('filename')!r}; looked for "
                        f"{', '.join(map(str, looked))}; name the folder of its package under meshes: in robot.yaml"
                    )
    return root


def find_mesh(filename: str, urdf: Path, folders: Sequence[Path]) -> tuple[Path | None, list[Path]]:
    """The file that a URDF's path means, and all the places where it was looked for.

    `package://NAME/REST` is looked for as NAME/REST and as REST in each folder, and in the folders above the URDF;
    what is not a URL, beside the URDF. What a URL writes as %20 is a space where no file's name has it so itself.
    """
    scheme, _, rest = filename.rpartition("://")
    looked = _places(scheme, rest, urdf, folders)
    if scheme and unquote(rest) != rest:
        looked += _places(scheme, unquote(rest), urdf, folders)
    return next((place for place in looked if place.is_file()), None), looked


def _places(scheme: str, rest: str, urdf: Path, folders: Sequence[Path]) -> list[Path]:
    if scheme not in ("package", "model"):
        return [urdf.resolve().parent / rest, *(folder / rest for folder in folders)]
    inner = rest.partition("/")[2]
    looked = [folder / part for folder in folders for part in (rest, inner)]
    looked += [folder / rest for folder in urdf.resolve().parents]
    return looked + [folder / inner for folder in urdf.resolve().parents if folder.name == rest.partition("/")[0]]


def _parse(path: Path) -> Element:
    try:
        text = read_regular(path, MAX_BYTES).decode("utf-8-sig")
    except FileNotFoundError:
        raise RobotError(f"{path}: no such URDF") from None
    except OSError as error:
        raise RobotError(f"{path}: cannot read the URDF: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise RobotError(f"{path}: cannot read the URDF: {error}") from error
    try:
        root = ElementTree.fromstring(_with_declared_prefixes(text))
    except ElementTree.ParseError as error:
        raise RobotError(f"{path}: not a URDF: {error}") from error
    if root.tag != "robot":
        raise RobotError(f"{path}: not a URDF: its root is <{root.tag}>, not <robot>")
    return root


def _with_declared_prefixes(text: str) -> str:
    """Text whose root declares every namespace prefix in use: `drake:` and `xacro:` often are not declared."""
    used = set(re.findall(r"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_][\w.-]*(?=[\s=/>])", text)) - {"xmlns", "xml"}
    missing = sorted(prefix for prefix in used if f"xmlns:{prefix}" not in text)
    declared = "".join(f' xmlns:{prefix}="urn:{prefix}"' for prefix in missing)
    return re.sub(r"<robot\b", f"<robot{declared}", text, count=1)


def _strip(element: Element) -> None:
    """Take away what belongs to other tools: elements and attributes with a namespace."""
    for key in [key for key in element.attrib if "}" in key]:
        del element.attrib[key]
    for child in list(element):
        if "}" in str(child.tag):
            element.remove(child)
        else:
            _strip(child)


def _weigh(link: Element) -> None:
    """Leave of a link's <inertial> what it says: a mass of 0 where there is a body is none, and so is no inertia."""
    for inertial in link.findall("inertial"):
        mass = inertial.find("mass")
        if mass is None or (float(mass.get("value", "")) == 0.0 and link.find("collision") is not None):
            link.remove(inertial)
        elif inertial.find("inertia") is None:
            moments = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0")
            ElementTree.SubElement(inertial, "inertia", moments)


def _drive(joint: Element, driven: Driven) -> None:
    if joint.get("type") == "continuous":
        joint.set("type", "revolute")
    if joint.find("axis") is None:
        ElementTree.SubElement(joint, "axis", xyz="1 0 0")  # what it is anyway; some readers warn
    limit = joint.find("limit")
    if limit is None:
        limit = ElementTree.SubElement(joint, "limit")
    for key, value in (("lower", driven.lower), ("upper", driven.upper), ("effort", driven.effort)):
        if (given := limit.get(key)) is None or float(given) != value:
            limit.set(key, repr(value))
    if limit.get("velocity") is None:
        limit.set("velocity", repr(driven.velocity))


def _end(joint: Element, role: str) -> str:
    element = joint.find(role)
    return "" if element is None else element.get("link", "")


def pose_of(element: Element, path: Path) -> Pose:
    """What an element's <origin> means; no turn and no way where it has none."""
    origin = element.find("origin")
    if origin is None:
        return Pose()
    return Pose.from_rpy(triple(origin, "xyz", path), triple(origin, "rpy", path))


def _place(joint: Element, pose: Pose) -> None:
    xyz, rpy = " ".join(map(repr, pose.xyz)), " ".join(map(repr, pose.rpy))
    ElementTree.SubElement(joint, "origin", xyz=xyz, rpy=rpy)


def _moved(axis: tuple[float, float, float], value: float, *, slides: bool) -> Pose:
    length = math.hypot(*axis) or 1.0
    x, y, z = (v / length for v in axis)
    if slides:
        return Pose((value * x, value * y, value * z))
    s = math.sin(value / 2)
    return Pose(quat=(s * x, s * y, s * z, math.cos(value / 2)))


def followers(driver: str, mimics: Mapping[str, Mimic]) -> Iterator[tuple[str, float, float]]:
    """Yield the joints that follow a driver, directly or through others: name, multiplier and offset against it."""
    for name, mimic in mimics.items():
        if mimic.joint == driver and name != driver:
            yield name, mimic.multiplier, mimic.offset
            rest = {other: m for other, m in mimics.items() if other not in (driver, name)}
            for further, multiplier, offset in followers(name, rest):
                yield further, multiplier * mimic.multiplier, multiplier * mimic.offset + offset
