"""The perceiver that is installed: poses of known objects from frames, with confidence, alternatives and "not seen"."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from tamp.perception.cameras.camera import Frame
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.candidates import Candidate, candidates, fitted
from tamp.perception.estimation.fit import polished
from tamp.perception.estimation.fusion import fuse, level
from tamp.perception.estimation.likeness import turned_by_color
from tamp.perception.estimation.model import ObjectModel, object_model
from tamp.perception.estimation.registration import register
from tamp.perception.estimation.selection import Selection
from tamp.perception.estimation.volume import Volume, survey
from tamp.perception.rendering.surface import Surface
from tamp.task.model import Table
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ROUNDS = 2
"""Times that objects are sought anew among points that nothing explains."""

AHEAD = 0.06
"""An estimate that explains so much more than the next, as a share, is trusted by two thirds."""

FEWEST = 25
"""An estimate that explains fewer points than this, and less than a fifth of the object's cells, is no sight of it."""


TRACKED = 0.03
"""An object that is expected somewhere is sought there first, within this [m]."""

SEEN_THROUGH = 0.06
"""One that was seen through more than this, as a share of its surface, is not there."""


def estimate_poses(
    frames: Sequence[Frame],
    objects: Mapping[str, Surface],
    *,
    table: Table | None = None,
    seed: int = 0,
    expected: Mapping[str, Pose] = MappingProxyType({}),
) -> dict[str, Estimate]:
    """Where objects are.

    Args:
        frames: pictures of one scene that stood still.
        objects: name -> mesh of everything that may be in the scene; objects of one mesh are told apart by nothing.
        table: the table top.
        seed: decides every guess.
        expected: name -> pose of what is known already; what is found there is sought nowhere else.

    Returns:
        An estimate for every object; its pose is None where the object was not seen.
    """
    top = Table() if table is None else table
    scene = see(frames, top)
    if scene is None:
        return {name: Estimate(None, 0.0) for name in objects}
    models = [object_model(surface) for surface in objects.values()]
    names = list(objects)
    found = _sought(scene, models, [expected.get(name) for name in names], seed)
    selection = Selection(scene.cloud, models, found)
    selection.solve()
    for number in range(1, ROUNDS + 1):
        if not _seek_again(scene, models, found, selection, seed + 1000 * number):
            break
        chosen = selection.chosen
        selection = Selection(scene.cloud, models, found)
        selection.chosen = chosen
        selection.solve()
    return {name: _estimate(scene, models[i], found[i], selection, i) for i, name in enumerate(names)}


def see(frames: Sequence[Frame], table: Table) -> Volume | None:
    """What frames say about the space over a table; None where nothing stands there, or nobody has looked."""
    if not frames:
        return None
    mended = register([level(frame, table) for frame in frames], table)
    cloud = fuse(mended, table)
    return None if len(cloud.points) < FEWEST else survey(mended, cloud)


def _sought(
    scene: Volume, models: Sequence[ObjectModel], expected: Sequence[Pose | None], seed: int
) -> list[list[Candidate]]:
    """Candidates of every object; objects of one mesh are sought once, unless masks tell them apart."""
    tree = cKDTree(scene.cloud.points)
    labels = scene.cloud.instances
    found: list[list[Candidate]] = []
    known: dict[int, list[Candidate]] = {}
    for i, model in enumerate(models):
        rng = np.random.default_rng([seed, i])
        if labels is not None:
            own = np.flatnonzero(labels == i)
            found.append(_masked(scene, model, own, rng))
        elif tracked := _tracked(scene, model, expected[i]):
            found.append(tracked)
        else:
            if id(model) not in known:
                known[id(model)] = candidates(scene, model, tree, rng)
            found.append(list(known[id(model)]))
    return found


def _tracked(scene: Volume, model: ObjectModel, expected: Pose | None) -> list[Candidate]:
    """Candidates where an object is expected; none where it is not, or nobody knows."""
    if expected is None:
        return []
    around = [Pose((x, y, 0.0)) for x, y in ((0.0, 0.0), (0.006, 0.0), (-0.006, 0.0), (0.0, 0.006), (0.0, -0.006))]
    poses = np.stack([shift.matrix @ expected.matrix for shift in around])
    middle = expected.matrix[:3, :3] @ model.center + expected.matrix[:3, 3]
    return [
        candidate
        for candidate in fitted(scene, model, poses)
        if candidate.violations < SEEN_THROUGH
        and candidate.weights.sum() > FEWEST
        and np.linalg.norm(candidate.pose[:3, :3] @ model.center + candidate.pose[:3, 3] - middle) < TRACKED
    ]


def _masked(scene: Volume, model: ObjectModel, own: NDArray[np.int64], rng: np.random.Generator) -> list[Candidate]:
    """Candidates from an object's own points alone; what it may explain of others' points does not count."""
    if len(own) < 5:
        return []
    cloud = scene.cloud.at(own)
    volume = Volume(cloud, scene.origin, _renumbered(scene, own), scene.free)
    found = candidates(volume, model, cKDTree(cloud.points), rng)
    return [Candidate(c.pose, own[c.points], c.weights, c.hits, c.violations, c.free_area) for c in found]


def _renumbered(scene: Volume, own: NDArray[np.int64]) -> NDArray[np.int32]:
    number = np.full(len(scene.cloud.points) + 1, -1, dtype=np.int32)
    number[own] = np.arange(len(own), dtype=np.int32)
    return np.asarray(number[scene.nearest])


def _seek_again(
    scene: Volume, models: Sequence[ObjectModel], found: list[list[Candidate]], selection: Selection, seed: int
) -> bool:
    """Add candidates through points that nothing explains, for objects that are explained badly; whether any came."""
    if scene.cloud.instances is not None:
        return False
    left = np.flatnonzero(selection.covered() < 0.3)
    if len(left) < FEWEST:
        return False
    tree = cKDTree(scene.cloud.points)
    came = False
    for i, model in enumerate(models):
        k = selection.chosen[i]
        gain = selection.gains(i)[k] if k >= 0 else 0.0
        if k >= 0 and gain > 0.75 * len(found[i][k].points) and found[i][k].violations < 0.05:
            continue
        more = candidates(scene, model, tree, np.random.default_rng([seed, i]), left)
        came = came or bool(more)
        found[i].extend(more)
    return came


def _estimate(scene: Volume, model: ObjectModel, found: Sequence[Candidate], selection: Selection, i: int) -> Estimate:
    k = selection.chosen[i]
    if k < 0:
        return Estimate(None, 0.0)
    best = found[k]
    gains = selection.gains(i)
    if gains[k] < FEWEST and best.hits < 0.2:
        return Estimate(None, 0.0)
    own = best.points[best.weights >= selection.covered(without=i)[best.points]]
    pose = turned_by_color(scene.cloud, model, polished(scene.cloud, model, best.pose, own), own)
    others = _alternatives(model, found, gains, k)
    # What the best pose explains more than the next: alone, or with another object in exchange.
    lead = min(gains[k] - max((gains[o] for o, _ in others), default=0.0), selection.lead_over_exchange(i))
    confidence = _confidence(best, float(gains[k]), float(lead))
    return Estimate(Pose.from_matrix(pose), confidence, tuple(Pose.from_matrix(found[o].pose) for o, _ in others[:5]))


def _alternatives(model: ObjectModel, found: Sequence[Candidate], gains: Array, k: int) -> list[tuple[int, float]]:
    """Candidates that differ from the chosen one by more than a symmetry, the best first."""
    probe = model.points[:60]
    turned = np.einsum("sij,kj->ski", model.symmetries[:, :3, :3], probe) + model.symmetries[:, None, :3, 3]
    best = found[k].pose
    same = turned @ best[:3, :3].T + best[:3, 3]
    others = []
    for o in np.argsort(-gains, kind="stable"):
        if o != k and gains[o] > 0:
            T = found[o].pose
            placed = probe @ T[:3, :3].T + T[:3, 3]
            apart = float(np.linalg.norm(same - placed, axis=2).mean(axis=1).min())
            if apart > 0.02:
                others.append((int(o), apart))
    return others


def _confidence(best: Candidate, gain: float, lead: float) -> float:
    """How much to trust an estimate, 0..1: how much was seen, how little contradicts it, how far the next is behind."""
    seen = 1 - np.exp(-gain / 60)
    clean = np.exp(-8 * best.violations)
    own = max(0.0, gain) / max(1.0, float(best.weights.sum()))
    ahead = max(0.0, lead) / max(1.0, gain)
    return float(np.clip(seen * clean * np.sqrt(own) * (1 - np.exp(-ahead / AHEAD)), 0.0, 1.0))
