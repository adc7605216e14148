"""Whether robot.yaml and its URDF are of one robot: an arm that is a chain, and at its end a hand with two fingers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tamp.errors import meant
from tamp.task.files.robot.robot_schema import RobotModel
from tamp.task.files.robot.urdf_file import Mimic, Urdf, followers
from tamp.task.files.robot.urdf_grammar import MOVABLE
from tamp.task.files.yaml_document import FieldPath

Misfit = tuple[FieldPath, str]
"""A field of robot.yaml, and what is wrong with it."""

DRIVEN = f"only {', '.join(MOVABLE[:-1])} and {MOVABLE[-1]} joints can be driven"


def misfits(model: RobotModel, urdf: Urdf) -> Iterator[Misfit]:
    """Yield what does not fit, what causes other complaints first.

    Raises:
        RobotError: where a joint lacks limits that it needs, or has some that are no numbers.
    """
    if unknown := list(_unknown(model, urdf)):  # all else looks them up
        yield from unknown
        return
    mimics = urdf.mimics()
    yield from _joints(model.arm.joints, ("arm", "joints"), urdf)
    yield from _joints(model.gripper.joints, ("gripper", "joints"), urdf)
    yield from _arm(model, urdf, mimics)
    yield from _gripper(model, urdf, mimics)
    yield from _hand(model, urdf, mimics)
    yield from _posture(model, urdf, mimics)
    for index, (one, other) in enumerate(model.disable_collisions):
        if one == other:
            yield ("disable_collisions", index), f"{one} is named twice; name two links"


def _unknown(model: RobotModel, urdf: Urdf) -> Iterator[Misfit]:
    """Joints and links that robot.yaml names and that are not there."""
    joints: list[tuple[FieldPath, str]] = []
    for part, names in (("arm", model.arm.joints), ("gripper", model.gripper.joints)):
        joints += [((part, "joints", index), name) for index, name in enumerate(names)]
    joints += [(("posture", name), name) for name in model.posture]
    links: list[tuple[FieldPath, str]] = [(("tool", "parent"), model.tool.parent)]
    links += [(("gripper", "fingers", index), name) for index, name in enumerate(model.gripper.fingers)]
    for index, pair in enumerate(model.disable_collisions):
        links += [(("disable_collisions", index), name) for name in pair]
    movable = [name for name, joint in urdf.joints.items() if joint.get("type") in MOVABLE]
    for kind, named, known, valid in (("joint", joints, urdf.joints, movable), ("link", links, urdf.links, urdf.links)):
        for field, name in named:
            if name not in known:
                has = ", ".join(sorted(valid)) or "none that moves"
                yield field, f"there is no {kind} {name!r}; {meant(name, valid)}the URDF has {has}"


def moving(model: RobotModel, mimics: dict[str, Mimic]) -> tuple[str, ...]:
    """The gripper's joints: those that robot.yaml names, and what follows the first of them."""
    driver = model.gripper.joints[0]
    return (*model.gripper.joints, *(name for name, _, _ in followers(driver, mimics)))


def _joints(names: Sequence[str], field: FieldPath, urdf: Urdf) -> Iterator[Misfit]:
    for index, name in enumerate(names):
        kind = urdf.joint(name).get("type")
        if kind not in MOVABLE:
            yield (*field, index), f"{name} is {kind} in the URDF; {DRIVEN}"
        if name in names[:index]:
            yield (*field, index), f"{name} is named twice"


def _arm(model: RobotModel, urdf: Urdf, mimics: dict[str, Mimic]) -> Iterator[Misfit]:
    field, joints, tool = ("arm", "joints"), model.arm.joints, model.tool.parent
    for index, name in enumerate(joints):
        if name in mimics:
            yield (*field, index), f"{name} mimics {mimics[name].joint} in the URDF; an arm's joints move independently"
    way = urdf.way(tool)
    for index, name in enumerate(joints):
        if name not in way:
            on = ", ".join(joint for joint in way if urdf.joint(joint).get("type") in MOVABLE) or "none that moves"
            yield (*field, index), f"{name} is not on the way from the base to tool.parent, {tool}; on it are {on}"
    ordered = tuple(name for name in way if name in joints)
    if ordered != joints:
        yield field, f"the order from the base outwards is {', '.join(ordered)}"


def _gripper(model: RobotModel, urdf: Urdf, mimics: dict[str, Mimic]) -> Iterator[Misfit]:
    field, (driver, *others) = ("gripper", "joints"), model.gripper.joints
    if driver in mimics:
        yield field, f"{driver} mimics {mimics[driver].joint}; name the joint that is driven first"
    known = {name for name, _, _ in followers(driver, mimics)}
    for index, name in enumerate(others, start=1):
        if name in mimics and name not in known:
            yield (*field, index), f"{name} mimics {mimics[name].joint} in the URDF, not {driver}"
    for name in moving(model, mimics):
        if name in model.arm.joints:
            yield field, f"{name} is one of arm.joints"
    for name in urdf.way(model.tool.parent):
        if name in moving(model, mimics):
            told = f"{model.tool.parent} moves with the gripper's {name}; name a link rigid with the arm's last joint"
            yield ("tool", "parent"), told


def _hand(model: RobotModel, urdf: Urdf, mimics: dict[str, Mimic]) -> Iterator[Misfit]:
    """The fingers are two links at the arm's end, each moved by the gripper."""
    left, right = model.gripper.fingers
    if left == right:
        yield ("gripper", "fingers"), f"{left} is named twice; name the two links that have the pads"
    last, joints = model.arm.joints[-1], moving(model, mimics)
    for index, finger in enumerate(model.gripper.fingers):
        way, field = urdf.way(finger), ("gripper", "fingers", index)
        if last not in way:
            yield field, f"{finger} is not carried by the arm's last joint, {last}: is it another arm's?"
        if urdf.links[finger].find("collision") is None:
            yield field, f"{finger} has no <collision> in the URDF; name the links that have the pads, or give it one"
        if not set(way) & set(joints):
            told = f"{finger} is moved by none of the gripper's joints, {', '.join(joints)}; both fingers must move"
            yield field, told


def _posture(model: RobotModel, urdf: Urdf, mimics: dict[str, Mimic]) -> Iterator[Misfit]:
    """What is not driven may stand still, unless it moves with the arm, or could not stand so."""
    driven = {*model.arm.joints, *moving(model, mimics)}
    for name, value in model.posture.items():
        field, kind = ("posture", name), urdf.joint(name).get("type")
        if name in driven:
            yield field, "is a joint of arm or gripper; only others have a posture"
        if kind not in MOVABLE:
            yield field, f"is {kind} in the URDF; only {', '.join(MOVABLE)} joints have a posture"
        elif (ends := urdf.limits(name)) is not None and not ends[0] <= value <= ends[1]:
            yield field, f"{value:g} is outside the joint's limits of {ends[0]:g} to {ends[1]:g}"
    for joint in model.arm.joints:
        for name, _, _ in followers(joint, mimics):
            if urdf.joint(name).get("type") in MOVABLE and name not in (*driven, *model.posture):
                told = f"{name} mimics {joint} in the URDF, which is not supported; a posture holds it still"
                yield ("arm", "joints"), told
