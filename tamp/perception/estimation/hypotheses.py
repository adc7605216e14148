"""Guesses where an object may be, from oriented points of its model and of the cloud, and how it may be turned there.

For what rests on a plane, one point with its normal fixes the rest; in general it takes two: the point pair features of
Drost, Ulrich, Navab and Ilic (CVPR 2010), looked up by their nearest neighbours instead of a hash.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from tamp.perception.estimation.fusion import Cloud
from tamp.perception.estimation.models.color import difference
from tamp.perception.estimation.models.object_model import ObjectModel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

UPRIGHT = 0.95
"""A normal with this vertical share says nothing about the yaw."""

HEIGHT = 0.006
"""How far a point's height may be from what resting on the table makes it [m]."""

PAIRS = 60000
"""Pairs of a model's points that features are stored of."""

ANGLE = 0.012
"""Metres that a radian is worth among features."""


def resting(
    cloud: Cloud, model: ObjectModel, seeds: NDArray[np.int64], rng: np.random.Generator, each: int = 10
) -> Array:
    """Poses in which the model rests on the table in one of its stable ways, through a seed point; (n, 4, 4)."""
    found = []
    points, normals, colors = (values[:300] for values in (model.points, model.normals, model.colors))
    for stable in model.stable:
        placed, facing = points @ stable.R.T, normals @ stable.R.T
        height = cloud.points[seeds, 2][:, None] - placed[:, 2] - stable.height
        fits = (np.abs(height) < HEIGHT) & (np.abs(facing[:, 2] - cloud.normals[seeds, 2][:, None]) < 0.18)
        fits &= difference(colors, cloud.colors[seeds][:, None]) < 9.0
        # A random few of the model's points that fit each seed.
        ranks = np.where(fits, rng.random(fits.shape), 2.0)
        chosen = np.argpartition(ranks, each, axis=1)[:, :each]
        rows, columns = np.nonzero(np.take_along_axis(ranks, chosen, axis=1) < 2.0)
        found.append(_turned(cloud, seeds[rows], placed, facing, chosen[rows, columns], stable.R, stable.height, rng))
    return np.concatenate(found) if found else np.empty((0, 4, 4))


def _turned(
    cloud: Cloud,
    seed: NDArray[np.int64],
    placed: Array,
    facing: Array,
    point: NDArray[np.int64],
    R: Array,
    height: float,
    rng: np.random.Generator,
) -> Array:
    """Poses that turn model points about the vertical onto seeds; where normals do not say how far, by chance."""
    target, normal = cloud.points[seed], facing[point]
    steep = np.abs(normal[:, 2]) > UPRIGHT
    repeats = np.where(steep, 4, 1)
    again = np.repeat(np.arange(len(seed)), repeats)
    target, point, seed, steep = target[again], point[again], seed[again], steep[again]
    seen, normal = cloud.normals[seed], facing[point]
    yaw = np.arctan2(seen[:, 1], seen[:, 0]) - np.arctan2(normal[:, 1], normal[:, 0])
    yaw = np.where(steep, rng.uniform(-np.pi, np.pi, len(yaw)), yaw)
    Z = np.zeros((len(yaw), 3, 3))
    Z[:, 0, 0] = Z[:, 1, 1] = np.cos(yaw)
    Z[:, 1, 0], Z[:, 0, 1], Z[:, 2, 2] = np.sin(yaw), -np.sin(yaw), 1.0
    poses = np.tile(np.eye(4), (len(yaw), 1, 1))
    poses[:, :3, :3] = Z @ R
    poses[:, :3, 3] = target - np.einsum("nij,nj->ni", Z, placed[point])
    poses[:, 2, 3] = height
    return poses


def anywhere(
    cloud: Cloud, model: ObjectModel, seeds: NDArray[np.int64], tree: Any, rng: np.random.Generator, count: int
) -> Array:
    """Poses in any orientation, from pairs of a seed and another point near it; (n, 4, 4)."""
    features, first, second = _pairs(model)
    a = rng.choice(seeds, size=count)
    b = _partners(cloud, model, a, tree, rng)
    a, b = a[b >= 0], b[b >= 0]
    wanted, apart = _features(cloud.points[a], cloud.normals[a], cloud.points[b], cloud.normals[b])
    a, b, wanted = a[apart > 0.008], b[apart > 0.008], wanted[apart > 0.008]
    if not len(a):
        return np.empty((0, 4, 4))
    distance, index = features.query(wanted, k=4, distance_upper_bound=0.008)
    rows, columns = np.nonzero(np.isfinite(distance))
    pair = index[rows, columns]
    a, b, i, j = a[rows], b[rows], first[pair], second[pair]
    fits = difference(model.colors[i], cloud.colors[a]) + difference(model.colors[j], cloud.colors[b]) < 12.0
    a, b, i, j = a[fits], b[fits], i[fits], j[fits]
    scene = _frames(cloud.points[a], cloud.normals[a], cloud.points[b])
    own = _frames(model.points[i], model.normals[i], model.points[j])
    poses = np.tile(np.eye(4), (len(a), 1, 1))
    poses[:, :3, :3] = scene @ own.transpose(0, 2, 1)
    middle = (cloud.points[a] + cloud.points[b]) / 2
    poses[:, :3, 3] = middle - np.einsum("nij,nj->ni", poses[:, :3, :3], (model.points[i] + model.points[j]) / 2)
    return poses


def in_place(model: ObjectModel, center: Array, rng: np.random.Generator, count: int) -> Array:
    """Poses in random orientations with the model's middle at a place, shape (3,) [m]; (count, 4, 4)."""
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, :3] = Rotation.random(count, random_state=rng).as_matrix()
    poses[:, :3, 3] = center - poses[:, :3, :3] @ model.center
    return poses


def _partners(
    cloud: Cloud, model: ObjectModel, a: NDArray[np.int64], tree: Any, rng: np.random.Generator
) -> NDArray[np.int64]:
    """For each seed a point at a random distance up to the model's diameter; -1 where there is none."""
    way = rng.normal(size=(len(a), 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    # Along the surface rather than through the air.
    way -= 0.8 * np.einsum("ij,ij->i", way, cloud.normals[a])[:, None] * cloud.normals[a]
    way /= np.linalg.norm(way, axis=1)[:, None]
    length = model.diameter * rng.uniform(0.15, 0.85, len(a))
    distance, index = tree.query(cloud.points[a] + length[:, None] * way, distance_upper_bound=0.03)
    return np.where(np.isfinite(distance), index, -1).astype(np.int64)


@lru_cache(maxsize=256)
def _pairs(model: ObjectModel) -> tuple[Any, NDArray[np.int64], NDArray[np.int64]]:
    """Features of pairs of the model's points, to be searched, and which pairs they are."""
    rng = np.random.default_rng(0)
    count = min(len(model.points), 800)
    first, second = rng.integers(0, count, size=(2, PAIRS))
    features, apart = _features(model.points[first], model.normals[first], model.points[second], model.normals[second])
    kept = apart > 0.008
    return cKDTree(features[kept]), first[kept], second[kept]


def _features(p: Array, n: Array, q: Array, m: Array) -> tuple[Array, Array]:
    """Distance and the three angles between two points' normals and the line between them, shape (k, 4) [m]."""
    line = q - p
    apart = np.linalg.norm(line, axis=1)
    unit = line / np.maximum(apart, 1e-9)[:, None]
    cosines = [np.einsum("ij,ij->i", u, v) for u, v in ((n, unit), (m, unit), (n, m))]
    angles = [ANGLE * np.arccos(np.clip(c, -1, 1)) for c in cosines]
    return np.column_stack([apart, *angles]), apart


def _frames(p: Array, n: Array, q: Array) -> Array:
    """Right-handed axes from a normal and the direction to another point, as columns, shape (k, 3, 3)."""
    x = q - p
    x /= np.maximum(np.linalg.norm(x, axis=1), 1e-9)[:, None]
    z = n - np.einsum("ij,ij->i", n, x)[:, None] * x
    z /= np.maximum(np.linalg.norm(z, axis=1), 1e-9)[:, None]
    return np.stack([x, np.cross(z, x), z], axis=2)
