"""Whether a URDF is one: all that is read of it is there, numbers are finite, links and joints form one tree.

What has passed is read by several libraries, each of which says what is wrong in its own way, or not at all: none is
asked. A complaint names the file, the link or joint, and what would be valid.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree.ElementTree import Element

from tamp.errors import RobotError

MOVABLE = ("revolute", "continuous", "prismatic")
KINDS = (*MOVABLE, "fixed", "floating", "planar")

SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "capsule": ("radius", "length")}
"""Of primitive shapes: the attributes that have their sizes [m]."""

LARGEST = 10.0
"""No link of a robot at a table has a box, cylinder, sphere or capsule as large as this [m]: it is in millimetres."""

DEFINITIONS = ("property", "arg", "macro")
"""Elements of xacro that do nothing by themselves."""


def require_expanded(source: Element, path: Path) -> None:
    """Refuse a file that xacro has still to make a URDF of.

    Raises:
        RobotError: where there is a macro or an expression of it.
    """
    for element in source.iter():
        space, _, name = str(element.tag).rpartition("}")
        if "xacro" in space and name not in DEFINITIONS:
            raise RobotError(f"{path}: has <xacro:{name}>; expand it first, by `xacro {path.name} > robot.urdf`")
    for element in (*source.findall("link"), *source.findall("joint")):
        for text in (text for part in element.iter() for text in part.attrib.values()):
            if "${" in text or "$(" in text:
                raise RobotError(f"{path}: has {text!r}; expand it first, by `xacro {path.name} > robot.urdf`")


def require_grammar(root: Element, path: Path) -> None:
    """Refuse links and joints that are no URDF.

    Args:
        root: the file's links and joints.
        path: the file, for messages.

    Raises:
        RobotError: for the first thing that is wrong.
    """
    for kind in ("link", "joint"):
        _require_names(root.findall(kind), kind, path)
    for link in root.findall("link"):
        _require_link(link, path, f"link {link.get('name')!r}")
    joints = root.findall("joint")
    for joint in joints:
        _require_joint(joint, path, f"joint {joint.get('name')!r}")
    _require_mimics({str(joint.get("name")): joint.find("mimic") for joint in joints}, path)
    _require_tree([str(link.get("name")) for link in root.findall("link")], joints, path)


def root_links(root: Element) -> list[str]:
    """Names of the links that no joint carries; of what has passed it is one."""
    children = {child.get("link") for child in root.iterfind("joint/child")}
    return [str(link.get("name")) for link in root.findall("link") if link.get("name") not in children]


def finite(element: Element, attribute: str, path: Path, owner: str = "", default: float = 0.0) -> float:
    """A number from an attribute, or its default; `owner` is what a complaint says of where it is.

    Raises:
        RobotError: where it is no finite number.
    """
    text = element.get(attribute)
    if text is None:
        return default
    where = f"{path}: {owner}{': ' * bool(owner)}"
    try:
        value = float(text)
    except ValueError:
        raise RobotError(f"{where}{attribute}={text!r} is not a number") from None
    if not math.isfinite(value):
        raise RobotError(f"{where}{attribute}={text!r} is not a finite number")
    return value


def triple(
    element: Element, attribute: str, path: Path, owner: str = "", default: str = "0 0 0"
) -> tuple[float, float, float]:
    """Three finite numbers from an attribute; RobotError where they are not."""
    text = element.get(attribute, default)
    where = f"{path}: {owner}{': ' * bool(owner)}"
    try:
        a, b, c = map(float, text.split())
    except ValueError:
        raise RobotError(f"{where}{attribute}={text!r} are not three numbers") from None
    if not all(map(math.isfinite, (a, b, c))):
        raise RobotError(f"{where}{attribute}={text!r} are not three finite numbers")
    return a, b, c


def _require_names(elements: list[Element], kind: str, path: Path) -> None:
    seen: set[str] = set()
    for element in elements:
        name = element.get("name")
        if not name:
            raise RobotError(f"{path}: a <{kind}> has no name")
        if name in seen:
            raise RobotError(f"{path}: two {kind}s are called {name!r}")
        seen.add(name)
    if not elements and kind == "link":
        raise RobotError(f"{path}: there is no <link> in it")


def _require_link(link: Element, path: Path, owner: str) -> None:
    for shape in (*link.findall("collision"), *link.findall("visual")):
        _require_origin(shape, path, f"{owner}: <{shape.tag}>")
        _require_shape(shape, path, f"{owner}: <{shape.tag}>")
    for inertial in link.findall("inertial"):
        _require_origin(inertial, path, f"{owner}: <inertial>")
        for mass in inertial.findall("mass"):
            if mass.get("value") is None or finite(mass, "value", path, f"{owner}: <mass>") < 0.0:
                raise RobotError(f"{path}: {owner}: <mass> needs a value of 0 or more [kg], not {mass.get('value')}")
        for inertia in inertial.findall("inertia"):
            for moment in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
                value = finite(inertia, moment, path, f"{owner}: <inertia>")
                if value < 0.0 and moment in ("ixx", "iyy", "izz"):
                    raise RobotError(f"{path}: {owner}: <inertia>: {moment}={value:g} must be 0 or more [kg m^2]")


def _require_origin(element: Element, path: Path, owner: str) -> None:
    for origin in element.findall("origin"):
        for attribute in ("xyz", "rpy"):
            triple(origin, attribute, path, f"{owner}: <origin>")


def _require_shape(shape: Element, path: Path, owner: str) -> None:
    geometry = shape.find("geometry")
    form = next(iter(geometry), None) if geometry is not None else None
    if form is None:
        if shape.tag == "collision":
            raise RobotError(f"{path}: {owner} has no geometry; valid are mesh, {', '.join(SIZES)}")
        return
    if form.tag == "mesh":
        if not form.get("filename"):
            raise RobotError(f"{path}: {owner}: <mesh> has no filename")
        if 0.0 in triple(form, "scale", path, f"{owner}: <mesh>", "1 1 1"):
            raise RobotError(f"{path}: {owner}: <mesh>: scale={form.get('scale')!r} makes it flat; none may be 0")
        return
    for attribute in SIZES.get(form.tag, ()):
        _require_size(form, attribute, path, f"{owner}: <{form.tag}>")


def _require_size(form: Element, attribute: str, path: Path, owner: str) -> None:
    """Refuse lengths of a shape that are none, or that must be in millimetres."""
    if form.get(attribute) is None:
        raise RobotError(f"{path}: {owner} has no {attribute}")
    if attribute == "size":
        values = triple(form, attribute, path, owner)
    else:
        values = (finite(form, attribute, path, owner),) * 3
    if min(values) <= 0.0:
        raise RobotError(f"{path}: {owner}: {attribute}={form.get(attribute)!r} must be greater than 0 [m]")
    if max(values) >= LARGEST:
        raise RobotError(
            f"{path}: {owner}: {attribute}={form.get(attribute)!r} is over {LARGEST:g} m: millimetres? a URDF's "
            "lengths are in metres"
        )


def _require_joint(joint: Element, path: Path, owner: str) -> None:
    kind = joint.get("type")
    if kind not in KINDS:
        raise RobotError(f"{path}: {owner} has the type {kind!r}; valid are {', '.join(KINDS)}")
    _require_origin(joint, path, owner)
    for axis in joint.findall("axis"):
        if triple(axis, "xyz", path, f"{owner}: <axis>", "1 0 0") == (0.0, 0.0, 0.0) and kind in MOVABLE:
            raise RobotError(f"{path}: {owner}: <axis> is 0 0 0; give the direction that it turns about or slides in")
    for limit in joint.findall("limit"):
        ends = () if kind == "continuous" else ("lower", "upper")  # what turns without end may say so by infinities
        for attribute in (*ends, "effort", "velocity"):
            finite(limit, attribute, path, f"{owner}: <limit>")


def _require_mimics(mimics: dict[str, Element | None], path: Path) -> None:
    for name, mimic in mimics.items():
        followed, seen = mimic, {name}
        while followed is not None:
            finite(followed, "multiplier", path, f"joint {name!r}: <mimic>")
            finite(followed, "offset", path, f"joint {name!r}: <mimic>")
            target = followed.get("joint")
            if target not in mimics:
                raise RobotError(f"{path}: joint {name!r} mimics {target!r}, which is no joint of the URDF")
            if target in seen:
                raise RobotError(f"{path}: joint {name!r} mimics itself, directly or through others")
            seen.add(target)
            followed = mimics[target]


def _require_tree(links: list[str], joints: list[Element], path: Path) -> None:
    """Refuse joints between links that are not there, links that hang on two, loops, and more roots than one."""
    known, carriers, carries = set(links), dict[str, str](), dict[str, list[str]]()
    for joint in joints:
        parent, child = (_end(joint, role, known, path) for role in ("parent", "child"))
        if child in carriers:
            raise RobotError(f"{path}: link {child!r} hangs on two joints; only trees are valid")
        carriers[child] = parent
        carries.setdefault(parent, []).append(child)
    roots = [link for link in links if link not in carriers]
    if len(roots) > 1:
        raise RobotError(f"{path}: needs exactly one root link, found {', '.join(roots)}")
    waiting = roots.copy()
    while waiting:
        link = waiting.pop()
        known.discard(link)
        waiting += carries.get(link, [])
    if known:
        raise RobotError(f"{path}: link {min(known)!r} hangs on itself: joints form a loop; only trees are valid")


def _end(joint: Element, role: str, links: set[str], path: Path) -> str:
    found = joint.find(role)
    link = None if found is None else found.get("link")
    if link is None:
        raise RobotError(f"{path}: joint {joint.get('name')!r} lacks its {role} link")
    if link not in links:
        raise RobotError(f"{path}: joint {joint.get('name')!r} has the {role} {link!r}, which is no link of the URDF")
    return link
