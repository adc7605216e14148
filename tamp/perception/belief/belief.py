"""Estimates of one look held against what was expected: what is confirmed, what has moved, what nobody sees."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.frozen import FrozenDict
from tamp.perception.cameras.camera import Frame
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.assignment import assigned
from tamp.perception.estimation.models.object_model import ObjectModel
from tamp.perception.evaluation import pose_error
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

UNCERTAIN = 0.3
"""An estimate of lower confidence is not trusted."""

CONFIRMED = 0.004
"""An estimate this near to what was expected (EDE) changes nothing [m]."""

NOISE, DOUBT = 0.010, 0.020
"""Estimates differ by up to `NOISE` where both are sure; by up to `DOUBT` more where one is not at all [m]."""

BROUGHT = 0.9
"""How sure it is that an object is where a plan should have brought it, as a share of how sure it was before.

Fingers feel what they miss and what they lose: of 372 that were let go of on OCRTOC 2021's fifty tables, planned from
known poses, 347 came to rest within a centimetre of where they should.
"""

LOST = 0.2
"""How sure it is that an object that fingers or eyes have missed is where it was, as a share of that before."""

APART = 10.0
"""What stands for the distance between an object and no estimate [m]."""


@dataclass(frozen=True, eq=False)
class Belief:
    """What is known of a scene.

    Attributes:
        estimates: object -> estimate; every object is there, with no pose where nobody knows.
        frames: what was seen last.
    """

    estimates: Mapping[str, Estimate]
    frames: tuple[Frame, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "estimates", FrozenDict(self.estimates))

    @property
    def poses(self) -> dict[str, Pose]:
        """Object -> pose (world frame), of those that are known."""
        return {name: e.pose for name, e in self.estimates.items() if e.pose is not None}

    def trusted(self, least: float = UNCERTAIN) -> dict[str, Pose]:
        """The poses of a confidence of at least so much."""
        return {name: pose for name, pose in self.poses.items() if self.estimates[name].confidence >= least}

    def expecting(self, poses: Mapping[str, Pose], lost: Collection[str] = ()) -> Belief:
        """The same with known objects where a plan should have brought them, which is less sure than having seen it.

        Args:
            poses: object -> where it should be by now.
            lost: objects that the fingers have closed beside, or that have left them on the way, or that were seen
                not to be where they should.
        """
        brought = {name: _brought(e, poses.get(name)) for name, e in self.estimates.items()}
        doubted = {name: replace(brought[name], confidence=LOST * brought[name].confidence) for name in lost}
        return Belief({**brought, **doubted})


def _brought(estimate: Estimate, pose: Pose | None) -> Estimate:
    if estimate.pose is None or pose is None or pose == estimate.pose:
        return estimate
    return replace(estimate, pose=pose, confidence=BROUGHT * estimate.confidence)


def tolerance(expected: Estimate, found: Estimate) -> float:
    """How far apart two estimates of an object that stood still may be (EDE) [m]."""
    return NOISE + DOUBT * (1.0 - min(expected.confidence, found.confidence))


def updated(
    models: Mapping[str, ObjectModel],
    expected: Mapping[str, Estimate],
    found: Mapping[str, Estimate],
    absent: Collection[str],
) -> dict[str, Estimate]:
    """What is to be believed after a look.

    Args:
        models: object -> model; objects of one model are told apart by where they were expected alone.
        expected: what was believed, with what has been done since.
        found: what a perceiver says.
        absent: objects at whose expected place the cameras saw something else behind.

    Returns:
        Where both agree, what was expected if it is confirmed or what was found is uncertain, else what was found,
        turned as the shape allows so that it is nearest to what was expected. Where they do not: what was found, unless
        that is less sure and nothing speaks against what was expected. What was not found stays where it was expected
        unless it is absent there.
    """
    matched = _matched(models, expected, found)
    return {name: _one(models[name], expected[name], matched[name], name in absent) for name in models}


def _one(model: ObjectModel, expected: Estimate, found: Estimate, absent: bool) -> Estimate:
    if expected.pose is None:
        return found
    if found.pose is None:
        return Estimate(None, 0.0) if absent else replace(expected, confidence=expected.confidence / 2)
    pose = nearest_turn(model, found.pose, expected.pose)
    _, off = pose_error(model, pose, expected.pose)
    confidence = max(found.confidence, expected.confidence)
    if not absent and found.confidence < min(UNCERTAIN, expected.confidence):
        return expected
    if off <= CONFIRMED and not absent:
        return replace(expected, confidence=confidence)
    if off <= tolerance(expected, found):
        return replace(found, pose=pose, confidence=confidence)
    return expected if not absent and found.confidence < expected.confidence else found


def nearest_turn(model: ObjectModel, pose: Pose, near: Pose) -> Pose:
    """Of all poses that the shape's symmetries make alike, the one nearest to another pose."""
    turned = pose.matrix @ model.symmetries
    corners = model.edge / 2 * np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])
    placed = np.einsum("nij,kj->nki", turned[:, :3, :3], corners) + turned[:, None, :3, 3]
    wanted = corners @ near.matrix[:3, :3].T + near.matrix[:3, 3]
    best = int(np.linalg.norm(placed - wanted, axis=2).mean(axis=1).argmin())
    return pose if best == 0 else Pose.from_matrix(turned[best])


def _matched(
    models: Mapping[str, ObjectModel], expected: Mapping[str, Estimate], found: Mapping[str, Estimate]
) -> dict[str, Estimate]:
    """The estimates under the names of the objects that are expected nearest to them, within each model."""
    kinds: dict[int, list[str]] = {}
    for name, model in models.items():
        kinds.setdefault(id(model), []).append(name)
    result = dict(found)
    for names in kinds.values():
        if len(names) > 1 and any(expected[name].pose is not None for name in names):
            costs = np.array([[_apart(expected[name], found[other]) for other in names] for name in names])
            for name, column in zip(names, assigned(costs), strict=True):
                result[name] = found[names[column]]
    return result


def _apart(expected: Estimate, found: Estimate) -> float:
    if expected.pose is None or found.pose is None:
        return APART
    return float(np.linalg.norm(np.subtract(expected.pose.xyz, found.pose.xyz)))
