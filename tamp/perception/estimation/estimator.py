"""The perceiver that is installed: poses of known objects from frames, with confidence, alternatives and "not seen"."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from tamp.perception.cameras.camera import Frame
from tamp.perception.estimate import Estimate
from tamp.perception.estimation.candidates import Candidate, candidates, fitted, judged, turned
from tamp.perception.estimation.confidence import AHEAD, confidence, lead
from tamp.perception.estimation.fit import polished
from tamp.perception.estimation.fusion import FEWEST, LEFT, Left, fuse, level
from tamp.perception.estimation.models.object_model import ObjectModel, object_model
from tamp.perception.estimation.registration import register
from tamp.perception.estimation.selection import OVERLAP, Selection
from tamp.perception.estimation.turns.likeness import fitted_turns, likeliest_turn
from tamp.perception.estimation.turns.rendered import CLEARLY, all_shown, turn_shown
from tamp.perception.estimation.verification import APART, CLOSER, POINTS, SURELY, TURNS, Verified, verify
from tamp.perception.estimation.volume import Volume, survey
from tamp.perception.rendering.surface import Surface
from tamp.task.model import Table
from tamp.task.pose import Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ROUNDS = 2
"""Times that objects are sought anew among points that nothing explains."""

ALIKE = 0.12
"""Objects whose diameters differ by less than this, as a share, are sought in each other's places."""

TRACKED = 0.03
"""An object that is expected somewhere is sought there first, within this [m]."""

SEEN_THROUGH = 0.06
"""One that was seen through more than this, as a share of its surface, is not there."""

RIVALS = 12
"""Poses in an object's place that are held against the chosen one."""

LIKELY = 3.0
"""What explains less by more than so many times `AHEAD` hardly takes anything from the trust in what was chosen."""


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
    surfaces, names = list(objects.values()), list(objects)
    models = [object_model(surface) for surface in surfaces]
    found = _sought(scene, models, [expected.get(name) for name in names], seed)
    masked = scene.cloud.instances is not None
    selection = Selection(scene.cloud, models, found, present=masked)
    selection.solve()
    for number in range(1, ROUNDS + 1):
        if not _seek_again(scene, models, found, selection, seed + 1000 * number):
            break
        selection = _chosen_anew(scene, models, found, selection)
    if not masked and _seek_in_exchange(scene, models, found, selection, seed + 1000 * (ROUNDS + 1)):
        selection = _chosen_anew(scene, models, found, selection)
    _seek_turned(scene, models, found, selection, seed + 1000 * (ROUNDS + 2))
    selection = _chosen_anew(scene, models, found, selection)
    verified = verify(scene, surfaces, models, found, selection)
    selection.chosen = [verified[i].candidate if i in verified else -1 for i in range(len(models))]
    # Masks say of each point whose it is: what is left is none's.
    left = Left(np.empty((0, 3))) if masked else Left.of(scene.cloud, selection.covered())
    return {
        name: _estimate(scene, surfaces[i], found[i], selection, i, verified.get(i), left)
        for i, name in enumerate(names)
    }


def see(frames: Sequence[Frame], table: Table) -> Volume | None:
    """What frames say about the space over a table; None where nothing stands there, or nobody has looked."""
    if not frames:
        return None
    mended = register([level(frame, table) for frame in frames], table)
    cloud = fuse(mended, table)
    return None if len(cloud.points) < FEWEST else survey(mended, cloud, table=table)


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
    volume = scene.of_points(own)
    return _among(own, candidates(volume, model, cKDTree(volume.cloud.points), rng))


def _among(own: NDArray[np.int64], found: Sequence[Candidate]) -> list[Candidate]:
    """Candidates that were judged by some points alone, by the numbers that these have among all."""
    return [replace(candidate, points=own[candidate.points]) for candidate in found]


def _seek_again(
    scene: Volume, models: Sequence[ObjectModel], found: list[list[Candidate]], selection: Selection, seed: int
) -> bool:
    """Add candidates for objects that are explained badly, among the points that no other explains; whether any came.

    Those points alone are fitted to: what shows little would always lose against what lies along others' surfaces. What
    shares space with a badly explained object and is nearly of its size may stand in its place: it is sought again too,
    by the points of both.
    """
    if scene.cloud.instances is not None or (selection.covered() < LEFT).sum() < FEWEST:
        return False
    sought: dict[int, set[int]] = {}
    for i in range(len(models)):
        if _explained_badly(found[i], selection, i):
            both = {i, *(j for j in selection.meeting(i) if _of_a_size(models[i], models[j]))}
            for j in both:
                sought[j] = sought.get(j, set()) | both
    more = {i: _judged_among(scene, models[i], selection, without, seed, i) for i, without in sorted(sought.items())}
    for i, came in more.items():
        _add(models, found, i, came)
    return any(more.values())


def _add(models: Sequence[ObjectModel], found: list[list[Candidate]], i: int, more: Sequence[Candidate]) -> None:
    """Give candidates of an object to all of its mesh: which one stands there is told only by who stands elsewhere."""
    for j, model in enumerate(models):
        if model is models[i]:
            found[j].extend(more)


def _explained_badly(found: Sequence[Candidate], selection: Selection, i: int) -> bool:
    k = selection.chosen[i]
    return k < 0 or found[k].violations >= 0.05 or bool(selection.gains(i)[k] <= 0.75 * len(found[k].points))


def _judged_among(
    scene: Volume, model: ObjectModel, selection: Selection, without: set[int], seed: int, i: int
) -> list[Candidate]:
    """Candidates for an object among the points that nothing explains but some objects that may be wrong."""
    volume = scene.of_points(np.flatnonzero(selection.covered(without=without) < LEFT))
    rest = candidates(volume, model, cKDTree(volume.cloud.points), np.random.default_rng([seed, i]))
    return judged(scene, model, np.array([candidate.pose for candidate in rest]))


def _seek_in_exchange(
    scene: Volume, models: Sequence[ObjectModel], found: list[list[Candidate]], selection: Selection, seed: int
) -> bool:
    """Seek objects where one of nearly their size was chosen and they have no good candidate; whether any came.

    What is alike leads the search to the one that shows more; without a candidate there that was sought as well, nobody
    could tell them apart.
    """
    came = False
    seen = [i for i, k in enumerate(selection.chosen) if k >= 0]
    for i in seen:
        for j in seen:
            best = found[j][selection.chosen[j]]
            if models[i] is models[j] or not _of_a_size(models[i], models[j]):
                continue
            there = selection.at(i, selection.center(j, selection.chosen[j]))
            most = max((float(found[i][at].weights.sum()) for at in there), default=0.0)
            if len(best.points) < FEWEST or most > (1 - AHEAD) * best.weights.sum():
                continue
            volume = scene.of_points(best.points)
            rest = candidates(volume, models[i], cKDTree(volume.cloud.points), np.random.default_rng([seed, i, j]))
            more = judged(scene, models[i], np.array([candidate.pose for candidate in rest]))
            came = came or bool(more)
            _add(models, found, i, more)
    return came


def _seek_turned(
    scene: Volume, models: Sequence[ObjectModel], found: list[list[Candidate]], selection: Selection, seed: int
) -> None:
    """Add candidates for each object that is seen: where it is, in any orientation."""
    labels = scene.cloud.instances
    for i, k in enumerate(selection.chosen):
        if k < 0:
            continue
        own = np.flatnonzero(selection.covered(without={i}) < LEFT if labels is None else labels == i)
        volume = scene.of_points(own)
        explained = np.flatnonzero(np.isin(own, found[i][k].points))
        poses = turned(volume, models[i], selection.center(i, k), explained, np.random.default_rng([seed, i]))
        if labels is None:
            _add(models, found, i, judged(scene, models[i], poses))
        else:
            found[i].extend(_among(own, judged(volume, models[i], poses)))


def _of_a_size(one: ObjectModel, other: ObjectModel) -> bool:
    """Whether two objects could be mistaken for each other from afar."""
    return bool(abs(np.log(one.diameter / other.diameter)) < ALIKE and abs(np.log(one.area / other.area)) < 3 * ALIKE)


def _chosen_anew(
    scene: Volume, models: Sequence[ObjectModel], found: Sequence[Sequence[Candidate]], before: Selection
) -> Selection:
    """The joint choice among more candidates, which begins with what was chosen before."""
    selection = Selection(scene.cloud, models, found, present=scene.cloud.instances is not None, before=before)
    selection.solve()
    return selection


def _estimate(
    scene: Volume,
    surface: Surface,
    found: Sequence[Candidate],
    selection: Selection,
    i: int,
    verified: Verified | None,
    left: Left,
) -> Estimate:
    if verified is None:
        return Estimate(None, 0.0)
    model = object_model(surface)
    k = verified.candidate
    best, gains = found[k], selection.gains(i)
    # Of poses in one place residuals have chosen; whether something stands there what fits in best with others tells.
    firm = max((k, *selection.at(i, selection.center(i, k))), key=lambda o: float(gains[o]))
    if scene.cloud.instances is None and gains[firm] < FEWEST and best.hits < 0.2:
        return Estimate(None, 0.0)
    sure = np.isfinite(verified.lead) and verified.lead > SURELY * CLOSER
    rivals = [] if sure else _rivals(selection, model, found, gains, i, k)
    if not sure and verified.rival is not None:
        rivals.append(verified.rival)
    pose, told = _shown(scene, surface, model, [verified.pose, *rivals], verified.own)
    if not verified.shown or pose is not verified.pose:
        pose = _turned(scene, surface, model, pose, verified.own)
    apart = [
        o for o in np.argsort(-gains, kind="stable") if gains[o] > 0 and model.error(best.pose, found[o].pose) > APART
    ]
    likely = (1 - LIKELY * AHEAD) * gains[k]
    others = [o for o in apart if gains[o] <= likely or not _fitted_alike(scene, model, found[o].pose, verified)]
    ahead = lead(selection, i, gains, others, verified, told)
    clash = OVERLAP * selection.clash(i, firm)
    goes_on = left.goes_on(scene.cloud.points[found[firm].points[found[firm].weights >= LEFT]])
    trust = confidence(found[firm], float(gains[firm]), clash, ahead, goes_on)
    return Estimate(Pose.from_matrix(pose), trust, tuple(Pose.from_matrix(found[o].pose) for o in others[:5]))


def _fitted_alike(scene: Volume, model: ObjectModel, pose: Array, verified: Verified) -> bool:
    """Whether a pose, (4, 4), is the chosen one once it fits its points as that does.

    Guesses err by a centimetre or two: a guess beside the pose that was made of another one is no other answer.
    """
    some = verified.own[:: max(1, len(verified.own) // POINTS)]
    return model.error(verified.pose, polished(scene.cloud, model, pose, some)) <= APART


def _rivals(
    selection: Selection, model: ObjectModel, found: Sequence[Candidate], gains: Array, i: int, k: int
) -> list[Array]:
    """Poses (4, 4) in the place of an object's candidate k that are clearly turned and explain hardly less."""
    best = found[k].pose
    return [
        found[o].pose
        for o in selection.at(i, selection.center(i, k))
        if gains[o] > (1 - AHEAD) * gains[k] and model.error(best, found[o].pose) > APART
    ][:RIVALS]


def _shown(
    scene: Volume, surface: Surface, model: ObjectModel, poses: Sequence[Array], own: NDArray[np.int64]
) -> tuple[Array, float]:
    """The pose, of several in one place, that whole pictures show; the first where they do not clearly show another.

    With it, how much likelier pictures are of the first than of any other, as a share of their likelihood's negative
    logarithm; 0 where that is not clear.

    A rack that lies the other way round explains as many points as well; that its bars are a millimetre beside shows
    only when what each view errs by is taken out.
    """
    if len(poses) == 1:
        return poses[0], 0.0
    some = own[:: max(1, len(own) // POINTS)]
    fitted = np.stack([polished(scene.cloud, model, pose, some) for pose in poses])
    shown = all_shown(scene.frames, [(surface, fitted[:1]), (surface, fitted[1:])])
    if shown is None:
        return poses[0], 0.0
    more, rival = shown[1].cost - shown[0].cost, fitted[1 + shown[1].pose]
    if more > -CLEARLY or model.error(fitted[0], rival) < APART:
        return poses[0], more / max(1.0, shown[0].cost) if more > CLEARLY else 0.0
    return np.asarray(rival), 0.0


def _turned(scene: Volume, surface: Surface, model: ObjectModel, pose: Array, own: NDArray[np.int64]) -> Array:
    """The pose, turned as its shape's near symmetries allow: as colours tell, or whole pictures where it has none."""
    turns = model.symmetries
    if not model.colored and 1 < len(turns) <= TURNS:
        poses = fitted_turns(scene.cloud, model, pose, own)
        shown = turn_shown(scene.frames, surface, poses)
        if shown is not None:
            return np.asarray(poses[shown])
    return likeliest_turn(scene.cloud, model, pose, own)
