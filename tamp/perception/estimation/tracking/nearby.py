"""Where an object is that should be somewhere: sought around there, among what no other object explains."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.cameras.camera import Frame
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.candidates import Candidate, fitted
from tamp.perception.estimation.confidence import AHEAD
from tamp.perception.estimation.fit import explained, polished
from tamp.perception.estimation.fusion import FEWEST, fuse, level
from tamp.perception.estimation.models.object_model import ObjectModel
from tamp.perception.estimation.registration import register
from tamp.perception.estimation.selection import FREE
from tamp.perception.estimation.verification import APART
from tamp.perception.estimation.volume import Volume, survey
from tamp.task.model import Table
from tamp.task.pose import Pose
from tamp.world.transforms import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SHIFTS = (0.025, 0.05)
"""How far beside its place an object is sought, in eight directions [m]."""

TURN, TILT = 0.35, 0.35
"""Turns about the vertical, and about level axes, that are tried [rad]."""

OPEN = 0.03
"""Poses that explain less by this share are as good: pictures leave open which it is, and it has hardly moved."""

OTHERS = 0.5
"""What another object explains better than this is not of the one that is sought."""


def estimate_nearby(
    frames: Sequence[Frame], models: Mapping[str, ObjectModel], poses: Mapping[str, Pose], name: str, table: Table
) -> Estimate:
    """Where an object is that was let go or pushed.

    Args:
        frames: pictures taken since then.
        models: object -> model.
        poses: object -> where it should be (world frame).
        name: the object.
        table: the table top.

    Returns:
        Its pose in the world frame, turned as its symmetries allow; None where too little of it is seen to tell. What
        is found elsewhere than expected is trusted by how much more it explains than staying there would.
    """
    model, expected = models[name], poses[name].matrix
    center = expected[:3, :3] @ model.center + expected[:3, 3]
    volume = unexplained(frames, models, poses, name, (center, model.diameter / 2 + max(SHIFTS)), table)
    if volume is None:
        return Estimate(None, 0.0)
    tried = np.stack([motion @ expected for motion in _motions(center)])
    return best_of(volume, model, fitted(volume, model, tried), expected)


def best_of(volume: Volume, model: ObjectModel, found: Sequence[Candidate], expected: Array) -> Estimate:
    """The candidate that explains most, or as much and is nearest to a pose (4, 4), fitted to what it explains."""
    worths = [_worth(c) for c in found]
    if not found or max(worths) < FEWEST:
        return Estimate(None, 0.0)
    worth = max(worths)
    alike = [c for c, w in zip(found, worths, strict=True) if w > (1 - OPEN) * worth]
    best = min(alike, key=lambda c: model.apart(c.pose, expected))
    others = [w for c, w in zip(found, worths, strict=True) if model.apart(best.pose, c.pose) > APART]
    ahead = (worth - max(others, default=0.0)) / worth / AHEAD
    confidence = (1 - np.exp(-worth / 60)) * np.exp(-8 * best.violations) * (1 - np.exp(-max(0.0, ahead)))
    pose = polished(volume.cloud, model, best.pose, best.points)
    return Estimate(Pose.from_matrix(pose), float(confidence))


def unexplained(
    frames: Sequence[Frame],
    models: Mapping[str, ObjectModel],
    poses: Mapping[str, Pose],
    name: str,
    ball: tuple[Array, float],
    table: Table,
) -> Volume | None:
    """The space in a ball, its centre (3,) and radius [m], with those points in it that no other object explains.

    None where too few are.
    """
    if not frames:
        return None
    center, reach = ball
    mended = register([level(frame, table) for frame in frames], table)
    cloud = fuse(mended, table)
    kept = np.linalg.norm(cloud.points - center, axis=1) < reach
    for other, pose in poses.items():
        if other != name:
            points, weights = explained(cloud, models[other], pose.matrix)
            kept[points[weights > OTHERS]] = False
    if kept.sum() < FEWEST:
        return None
    return survey(mended, cloud.at(kept), (center - reach, center + reach))


def _motions(center: Array) -> Iterator[Array]:
    """Motions of what was let go beside its place, in the world frame, shape (4, 4) each."""
    ways = [np.array([np.cos(a), np.sin(a), 0.0]) for a in np.arange(8) * np.pi / 4]
    shifts = [np.zeros(3), *(distance * way for distance in SHIFTS for way in ways)]
    turns = [rotation(np.array([0.0, 0.0, 1.0]), angle) for angle in (0.0, TURN, -TURN)]
    for R in turns:
        for shift in shifts:
            yield _moved(R, center, shift)
    for way in ways[::2]:
        yield _moved(rotation(way, TILT), center, np.zeros(3))


def _moved(R: Array, center: Array, shift: Array) -> Array:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, center - R @ center + shift
    return T


def _worth(candidate: Candidate) -> float:
    """What a pose explains, less what cameras saw through, in points."""
    return float(candidate.weights.sum()) - FREE * candidate.free_area
