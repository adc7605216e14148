"""A few good and different poses of one object: guess many, glance, fit, keep the best of each neighbourhood."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.perception.estimation.fit import agreement, explained, glance, polished, refine, turned_about_middle
from tamp.perception.estimation.fusion import VOXEL, Cloud
from tamp.perception.estimation.hypotheses import anywhere, in_place, resting
from tamp.perception.estimation.matching import distinct
from tamp.perception.estimation.models.color import difference
from tamp.perception.estimation.models.object_model import COARSE, FINE, ObjectModel
from tamp.perception.estimation.turns.likeness import likeliest_near, misfits
from tamp.perception.estimation.volume import Volume

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SEEDS = 160
"""Points of the cloud that guesses go through."""

GUESSES = 24000
"""Most guesses that are glanced at, of each kind."""

FITTED = 72
"""Guesses that are fitted."""

KEPT = 24
"""Candidates for the joint choice."""

TURNED = 6000
"""Orientations that are tried in one place: one within 10 degrees of nearly any."""

ANGLES, TURNS = (0.2, 0.1, 0.05, 0.025), 48
"""By how much, about each axis, the best of them are turned on [rad], and how often at each step."""

LIKELIEST = 16
"""Orientations that are fitted by colours."""

GLANCED, JUDGED = 60, 120
"""Points, at most, that all orientations are judged by, and those that are fitted."""

LOOSELY = 0.003
"""How far points are from the surface of a pose that was not fitted yet: their standard deviation [m]."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A pose that an object may have.

    Attributes:
        pose: T_world_object, shape (4, 4).
        points: indices of the measured points that it explains.
        weights: how well it explains them, 0..1.
        hits, violations: shares of the model's surface that were measured there, and that were seen through.
        free_area: surface that was seen through, in cells of the cloud.
    """

    pose: Array
    points: NDArray[np.int64]
    weights: Array
    hits: float
    violations: float
    free_area: float


def candidates(
    volume: Volume,
    model: ObjectModel,
    tree: Any,
    rng: np.random.Generator,
    among: NDArray[np.int64] | None = None,
) -> list[Candidate]:
    """The best poses of a model, each clearly different from the others.

    Args:
        volume: what was measured.
        model: the object.
        tree: nearest-neighbour search among the cloud's points.
        rng: source of all guesses.
        among: indices of points of the cloud that guesses must go through; None is all.
    """
    cloud = volume.cloud
    seeds = _seeds(cloud, model, np.arange(len(cloud.points)) if among is None else among, rng)
    if not len(seeds):
        return []
    kinds = (resting(cloud, model, seeds, rng), anywhere(cloud, model, seeds, tree, rng, GUESSES // 4))
    chosen = []
    for guesses in kinds:
        if len(guesses) > GUESSES:
            guesses = guesses[rng.choice(len(guesses), GUESSES, replace=False)]
        if len(guesses):
            best = guesses[np.argsort(-glance(volume, model, guesses, COARSE), kind="stable")[: 8 * FITTED]]
            first = best[different(best, model, 0.012, 0.25, len(best))]
            chosen.append(first[np.argsort(-glance(volume, model, first, 3 * COARSE), kind="stable")[:FITTED]])
    if not chosen:
        return []
    return fitted(volume, model, np.concatenate(chosen))


def turned(
    volume: Volume, model: ObjectModel, center: Array, own: NDArray[np.int64], rng: np.random.Generator
) -> Array:
    """The best poses of a model with its middle at a place, (3,) [m], in whatever orientation, shape (n, 4, 4).

    Of what is nearly round any orientation fits; that its colours do too is seen within a few degrees alone. So many
    orientations are tried, and the best are fitted by shape. What has no colours is then turned a little as long as it
    fits better; what has is also fitted by how likely its `own` points are, indices of some of the cloud's.
    """
    poses = in_place(model, center, rng, TURNED)
    best = np.argsort(-agreement(volume, model, poses).score, kind="stable")[:FITTED]
    found = np.array([c.pose for c in fitted(volume, model, poses[best])]).reshape(-1, 4, 4)
    if model.colored:
        return np.concatenate([_likeliest(volume.cloud, model, poses, own), found])
    return _turned_on(volume, model, found, rng)


def _turned_on(volume: Volume, model: ObjectModel, poses: Array, rng: np.random.Generator) -> Array:
    """Poses (n, 4, 4) turned about their middles to the best of some small turns, ever smaller ones."""
    for angle in ANGLES:
        tried = np.repeat(poses, TURNS, axis=0)
        turns = angle * rng.normal(size=(len(tried), 3))
        turns[::TURNS] = 0.0
        tried = turned_about_middle(model, tried, turns)
        scores = agreement(volume, model, tried, 2 * FINE).score.reshape(len(poses), TURNS)
        poses = tried.reshape(len(poses), TURNS, 4, 4)[np.arange(len(poses)), scores.argmax(axis=1)]
    return poses


def _likeliest(cloud: Cloud, model: ObjectModel, poses: Array, own: NDArray[np.int64]) -> Array:
    """The likeliest of poses (n, 4, 4), each clearly different from the others, fitted to points: first by shape.

    Until they are fitted, poses lie beside the points: what that costs must not outweigh the colours.
    """
    few, some = (own[:: max(1, -(-len(own) // count))] for count in (GLANCED, JUDGED))
    order = np.argsort(misfits(cloud, model, poses, few, LOOSELY), kind="stable")
    kept = poses[order[different(poses[order], model, 0.006, 0.2, LIKELIEST)]]
    return np.stack([likeliest_near(cloud, model, polished(cloud, model, pose, some), some)[0] for pose in kept])


def fitted(volume: Volume, model: ObjectModel, poses: Array) -> list[Candidate]:
    """The best of some poses after fitting."""
    poses = refine(volume, model, poses, rounds=6, points=160)
    order = np.argsort(-agreement(volume, model, poses, 160).score, kind="stable")
    poses = poses[order]
    poses = poses[different(poses, model, 0.006, 0.12, KEPT + 8)]
    poses = refine(volume, model, poses, rounds=8)
    order = np.argsort(-agreement(volume, model, poses).score, kind="stable")
    order = order[different(poses[order], model, 0.005, 0.10, KEPT)]
    return judged(volume, model, poses[order])


def judged(volume: Volume, model: ObjectModel, poses: Array) -> list[Candidate]:
    """Poses, shape (n, 4, 4), with what they explain and violate, in order."""
    if not len(poses):
        return []
    found = agreement(volume, model, poses, len(model.points))
    cells = model.area / VOXEL**2
    return [
        Candidate(
            pose, *explained(volume.cloud, model, pose), float(hits), float(violations), float(violations * cells)
        )
        for pose, hits, violations in zip(poses, found.hits, found.violations, strict=True)
    ]


def different(poses: Array, model: ObjectModel, apart: float, turned: float, most: int) -> NDArray[np.int64]:
    """Indices of poses, in order, that are not near an earlier one: in place [m] or by angle [rad]; at most so many."""
    centers = poses[:, :3, :3] @ model.center + poses[:, :3, 3]
    return distinct(poses, centers, apart, 1 + 2 * float(np.cos(turned)), most)


def _seeds(cloud: Cloud, model: ObjectModel, among: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.int64]:
    """Points spread over the cloud, rather where its colour occurs on the model."""
    if len(among) <= SEEDS:
        return among
    palette = model.colors[:200]
    many = rng.choice(among, size=min(len(among), 8 * SEEDS), replace=False)
    nearest = difference(cloud.colors[many][:, None], palette).min(axis=1)
    chance = 0.02 + np.exp(-0.5 * nearest)
    return np.asarray(rng.choice(many, size=SEEDS, replace=False, p=chance / chance.sum()))
