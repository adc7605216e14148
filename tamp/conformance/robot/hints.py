"""What a robot's links tell of fields that are wrong in its file: faces of the fingers, a home, pairs that touch."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.conformance.findings import Finding
from tamp.task import RobotSpec, Table
from tamp.world.collision.checker import CollisionChecker
from tamp.world.kinematics.inverse import inverse
from tamp.world.robot.linkage import finger_frames
from tamp.world.robot.model import RobotModel
from tamp.world.robot.urdf import link_shapes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

FACE = 0.0002  # what is no farther from a finger's innermost point, along the closing axis, is of its face [m]
FLAT = 0.4  # a finger's face that is flat over a smaller share of its pad is worth a note
HOVERS = (0.3, 0.25, 0.35, 0.2, 0.4)  # heights of the tool over the table at home that are tried [m]
TURNS = 8  # of the hand about the vertical
TRIED = 8  # configurations for each
SAMPLES = 200  # random configurations at which pairs of links are looked at
OFTEN = 0.3  # links that touch in more than this share of them hardly do so in truth


def described(spec: RobotSpec) -> Iterator[Finding]:
    """What there is, and where the fingers' surfaces are: who looks for `gripper.pads` finds them there."""
    shapes = link_shapes(spec)
    movable = len(spec.joints) + len(spec.gripper.joints)
    yield Finding("description", "ok", f"{spec.urdf.name}, {movable} joints, {len(shapes)} hulls")
    for finger in spec.gripper.fingers:
        points = np.concatenate([np.empty((0, 3)), *(s.hull.vertices for s in shapes if s.link == finger)])
        if not len(points):
            yield Finding("fingers", "wrong", f"{finger} has no collision geometry; name the links that have the pads")
            continue
        spans = (
            f"{axis} {low:.4f} to {high:.4f}"
            for axis, low, high in zip("xyz", points.min(0), points.max(0), strict=True)
        )
        yield Finding("fingers", "ok", f"{finger} spans {', '.join(spans)} m in its own frame")
    if faces := inner_faces(spec):
        left, right = (f"[{', '.join(f'{v:.4f}' for v in np.round(face.middle, 4) + 0.0)}]" for face in faces)
        yield Finding("faces", "ok", f"the middles of the fingers' inner faces, as pads has them: [{left}, {right}]")
        width, length = min(face.width for face in faces), min(face.length for face in faces)
        if width < FLAT * spec.gripper.pad[1] or length < FLAT * spec.gripper.pad[2]:
            sizes = f"{1000 * width:.1f} by {1000 * length:.1f} mm, gripper.pad says"
            text = f"the fingers' inner faces are flat over {sizes} {1000 * spec.gripper.pad[1]:g} by"
            text += f" {1000 * spec.gripper.pad[2]:g}: what round or edged fingers hold may turn"
            yield Finding("faces", "note", text)


@dataclass(frozen=True, eq=False)
class Face:
    """The flat of a finger's hull that looks at the other finger.

    Attributes:
        middle: in the finger link's frame, (3,) [m].
        width, length: across closing axis and approach, and along the approach [m].
    """

    middle: Array
    width: float
    length: float


def inner_faces(spec: RobotSpec) -> tuple[Face, ...]:
    """Of both fingers, the driver at its lower limit; none where a finger has no hull."""
    frames = finger_frames(spec, np.array([spec.gripper.limits[0]]))[0]
    points = [
        np.concatenate([np.empty((0, 3)), *(s.hull.vertices for s in link_shapes(spec) if s.link == name)])
        for name in spec.gripper.fingers
    ]
    if not all(len(own) for own in points):
        return ()
    centers = [T[:3, :3] @ own.mean(axis=0) + T[:3, 3] for own, T in zip(points, frames, strict=True)]
    axis = np.array(spec.gripper.axis)
    inwards = axis * np.sign((centers[1] - centers[0]) @ axis)  # of the first finger, in the tool frame
    return tuple(_face(own, T, way) for own, T, way in zip(points, frames, (inwards, -inwards), strict=True))


def _face(points: Array, T_tool_finger: Array, inwards: Array) -> Face:
    """Of points (n, 3) in the finger's frame [m], what is farthest inwards, a direction in the tool frame."""
    R = T_tool_finger[:3, :3]
    along = points @ (R.T @ inwards)
    face = points[along > along.max() - FACE]
    size = np.ptp(face @ R.T, axis=0)
    middle = (face.min(axis=0) + face.max(axis=0)) / 2
    middle += (along.max() - middle @ (R.T @ inwards)) * (R.T @ inwards)
    return Face(middle, float(size @ np.abs(np.cross(inwards, (0.0, 0.0, 1.0)))), float(size[2]))


def free_home(robot: RobotModel, checker: CollisionChecker) -> Array | None:
    """A configuration with the hand straight down over the table, in the middle of `reach`, that touches nothing.

    Of several the one that is farthest from its joints' limits; None where none was found.

    Args:
        robot: the robot.
        checker: with the margin that home should have.
    """
    spec = robot.spec
    foot = np.array(spec.T_world_base.xyz[:2])
    way = np.array(Table().center) - foot
    place = foot + way / np.linalg.norm(way) * np.mean(spec.reach)
    for height in HOVERS:
        found = [
            q
            for turn in np.arange(TURNS) * 2 * np.pi / TURNS
            for q in inverse(robot, _down(place, height, turn), np.random.default_rng(0), count=TRIED)
            if checker.free(q)
        ]
        if found:
            spare = [np.minimum(q - robot.lower, robot.upper - q).min() for q in found]
            return found[int(np.argmax(spare))]
    return None


def often_touching(robot: RobotModel, checker: CollisionChecker) -> list[tuple[str, float]]:
    """Pairs of links that are in each other at a large share of random configurations, and that share.

    Where more than one pair touches only the first counts, so that shares are lower bounds.
    """
    links = {body.name for body in robot.bodies}
    rng, counts = np.random.default_rng(0), Counter[str]()
    for _ in range(SAMPLES):
        contact = checker.contact(rng.uniform(robot.lower, robot.upper))
        if contact is not None and {contact.a, contact.b} <= links:
            counts[" and ".join(sorted((contact.a, contact.b)))] += 1
    return [(pair, count / SAMPLES) for pair, count in counts.most_common() if count > OFTEN * SAMPLES]


def _down(place: Array, height: float, turn: float) -> Array:
    """The tool straight down over a place (2,) [m], turned about the vertical."""
    c, s, T = np.cos(turn), np.sin(turn), np.eye(4)
    T[:3, :3] = np.diag([1.0, -1.0, -1.0]) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    T[:3, 3] = *place, height
    return T
