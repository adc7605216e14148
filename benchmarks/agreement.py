"""Do three libraries see the same collisions? Coal as tamp.world asks it, python-fcl, and PyBullet.

Random scenes, most of them within a centimetre of touching: two bodies, or the whole robot among objects. Where two
libraries differ by more than a millimetre, the exact distance of the convex parts says which of them is off: it is the
distance of the origin from their Minkowski difference. `off` counts that for each library, `misses` those of them that
take bodies for farther apart, or less deep in each other, than they are. `unexplained` must be 0, and so should be the
misses of coal, which plans rest on, and of fcl, whose depths the checker believes where they are small.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from benchmarks.parts.agreement_bodies import Body, Library, bodies_of_scenarios, links, random_convex
from benchmarks.parts.agreement_scenes import MARGIN, Scenes, pushed
from benchmarks.parts.harness import Row, main
from tamp.task.mesh.parts import Part

Array = NDArray[np.float64]

LIBRARIES = ("coal", "fcl", "bullet")
APART = 0.001
"""Differences up to this are agreement [m]."""
RANGE = (-0.006, 0.014)
"""Signed distances at which pairs are placed [m]."""


def run(quick: bool) -> Sequence[Row]:
    count = 100 if quick else 20_000
    rng = np.random.default_rng(0)
    convex, concave, robot = random_convex(rng, 40), bodies_of_scenarios(), links()
    kinds = {
        "links, convex objects": (robot, convex),
        "links, concave objects": (robot, concave),
        "convex objects": (convex, convex),
        "concave objects": (concave, concave),
    }
    with Library((*convex, *concave, *robot)) as library:
        rows = [pairs(name, library, islice(placed(rng, *kind), count)) for name, kind in kinds.items()]
        return [*rows, whole_scenes(Scenes(library, robot, (*convex, *concave)), rng, count)]


def placed(
    rng: np.random.Generator, first: Sequence[Body], second: Sequence[Body]
) -> Iterator[tuple[Body, Body, Array]]:
    """Random pairs with T_a_b, at distances drawn from RANGE."""
    while True:
        a, b = first[rng.integers(len(first))], second[rng.integers(len(second))]
        yield a, b, pushed(rng, a, b, rng.uniform(*RANGE))


def pairs(name: str, library: Library, scenes: Iterator[tuple[Body, Body, Array]]) -> Row:
    """Ask all three about each pair."""
    row = _empty(name)
    for a, b, T in scenes:
        said = {"coal": a.coal(b, T), "fcl": a.fcl(b, T), "bullet": library.bullet(a, b, T)}
        row["asked"] += 1
        if max(said.values()) - min(said.values()) > APART:
            truth = exact(a.parts, b.parts, T)
            _explain(row, {who: value - truth for who, value in said.items()})
    return row


def whole_scenes(scenes: Scenes, rng: np.random.Generator, count: int) -> Row:
    """Is the robot free by a margin at a random configuration among random objects?

    Coal says yes or no; that differs from a distance which lies clearly on the other side of the margin.
    """
    row = _empty("robot among objects")
    for _ in range(count):
        free, nearest = scenes.ask(rng)
        said = {who: distance - MARGIN for who, (distance, _) in nearest.items()}
        row["asked"] += 1
        if any(d < -APART if free else d > APART for d in said.values()):
            truth = min(exact(a.parts, b.parts, T) for _, (a, b, T) in nearest.values()) - MARGIN
            coal = max(-truth, 0.0) if free else min(-truth, 0.0)
            _explain(row, {"coal": coal, **{who: d - truth for who, d in said.items()}})
    return row


def _empty(name: str) -> Row:
    columns = [f"{who}_{what}" for what in ("off", "misses") for who in LIBRARIES]
    worst = [f"{who}_mm" for who in LIBRARIES]
    return {"scenes": name, **dict.fromkeys(("asked", "differ", "unexplained", *columns, *worst), 0)}


def _explain(row: Row, errors: Mapping[str, float]) -> None:
    """Count a disagreement by who is how far from the truth [m]."""
    row["differ"] += 1
    row["unexplained"] += all(abs(error) <= APART / 2 for error in errors.values())
    for who, error in errors.items():
        row[f"{who}_off"] += abs(error) > APART / 2
        row[f"{who}_misses"] += error > APART / 2
        row[f"{who}_mm"] = max(row[f"{who}_mm"], 1000 * abs(error))


def exact(a: Sequence[Part], b: Sequence[Part], T_a_b: Array) -> float:
    """Signed distance of two unions of convex parts [m]: the least over their pairs."""
    return min(_exact(one, two, T_a_b) for one in a for two in b)


def _exact(a: Part, b: Part, T_a_b: Array) -> float:
    """Penetration by the hull of the Minkowski difference; distance as the least point of that polytope.

    The latter is a least distance problem, solved as one of non-negative least squares (Lawson and Hanson, "Solving
    Least Squares Problems", 1974, chapter 23).
    """
    from scipy.optimize import nnls
    from scipy.spatial import ConvexHull

    moved = b.vertices @ T_a_b[:3, :3].T + T_a_b[:3, 3]
    planes = ConvexHull((a.vertices[:, None] - moved[None]).reshape(-1, 3)).equations
    if (apart := float(planes[:, 3].max())) <= 0.0:
        return apart
    E = np.vstack([-planes[:, :3].T, planes[:, 3]])
    u, _ = nnls(E, np.array([0.0, 0.0, 0.0, 1.0]))
    residual = E @ u - np.array([0.0, 0.0, 0.0, 1.0])
    return float(np.linalg.norm(residual[:3] / residual[3]))


if __name__ == "__main__":
    main("agreement", run)
