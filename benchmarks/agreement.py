"""Do three libraries see the same collisions? Coal as tamp.world asks it, python-fcl as the checker does, and PyBullet.

Random scenes, most of them within a centimetre of touching: two bodies, or the whole robot among objects. Where two
libraries differ by more than a millimetre, the exact distance of the convex parts says which of them is off, and by how
much: it is the distance of the origin from their Minkowski difference. `coal_off`, `fcl_off` and `bullet_off` count
that; `coal_misses` those of coal's that hide over a millimetre of penetration. `unexplained` must be 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from benchmarks.agreement_bodies import Body, Library, bodies_of_scenarios, links, random_convex
from benchmarks.agreement_scenes import MARGIN, Scenes, pushed
from benchmarks.harness import Row, main
from tamp.checking.solids import penetration
from tamp.task.mesh import Part

Array = NDArray[np.float64]

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
    row: Row = {"scenes": name, "asked": 0, "differ": 0, "coal_off": 0, "fcl_off": 0, "bullet_off": 0}
    row |= {"coal_misses": 0, "unexplained": 0, "spread_mm": 0.0, "coal_mm": 0.0, "fcl_mm": 0.0, "bullet_mm": 0.0}
    for a, b, T in scenes:
        said = {"coal": a.coal(b, T), "fcl": a.fcl(b, T), "bullet": library.bullet(a, b, T)}
        row["asked"] += 1
        spread = max(said.values()) - min(said.values())
        row["spread_mm"] = max(row["spread_mm"], 1000 * spread)
        if spread <= APART:
            continue
        row["differ"] += 1
        truth = exact(a.parts, b.parts, T)
        off = {who: value - truth for who, value in said.items()}
        for who, error in off.items():
            row[f"{who}_off"] += abs(error) > APART / 2
            row[f"{who}_mm"] = max(row[f"{who}_mm"], 1000 * abs(error))
        row["coal_misses"] += said["coal"] > 0 and truth < -APART
        row["unexplained"] += all(abs(error) <= APART / 2 for error in off.values())
    return row


def whole_scenes(scenes: Scenes, rng: np.random.Generator, count: int) -> Row:
    """Is the robot free at a random configuration among random objects, with a margin? The three say yes or no."""
    row: Row = {"scenes": "robot among objects", "asked": 0, "differ": 0, "coal_off": 0, "fcl_off": 0, "bullet_off": 0}
    row |= {"coal_misses": 0, "unexplained": 0}
    for _ in range(count):
        free, nearest = scenes.ask(rng)
        row["asked"] += 1
        # An answer of coal's is a yes or no at its margin; it differs where a distance lies clearly on the other side.
        said = {who: distance - MARGIN for who, (distance, _) in nearest.items()}
        if not any(d < -APART if free else d > APART for d in said.values()):
            continue
        row["differ"] += 1
        truth = min(exact(a.parts, b.parts, T) for _, (a, b, T) in nearest.values()) - MARGIN
        wrong = {who: abs(d - truth) > APART / 2 for who, d in said.items()}
        wrong["coal"] = truth < -APART / 2 if free else truth > APART / 2
        for who, is_off in wrong.items():
            row[f"{who}_off"] += is_off
        row["coal_misses"] += free and truth < -APART
        row["unexplained"] += not any(wrong.values())
    return row


def exact(a: Sequence[Part], b: Sequence[Part], T_a_b: Array) -> float:
    """Signed distance of two unions of convex parts [m]: the least over their pairs."""
    return min(_exact(one, two, T_a_b) for one in a for two in b)


def _exact(a: Part, b: Part, T_a_b: Array) -> float:
    """Penetration by the checker's own Minkowski difference; distance as the least point of that polytope.

    The latter is a least distance problem, solved as one of non-negative least squares (Lawson and Hanson, "Solving
    Least Squares Problems", 1974, chapter 23).
    """
    from scipy.optimize import nnls
    from scipy.spatial import ConvexHull

    depth = penetration(a, b, T_a_b)
    if depth >= 0.0:
        return -depth
    moved = b.vertices @ T_a_b[:3, :3].T + T_a_b[:3, 3]
    planes = ConvexHull((a.vertices[:, None] - moved[None]).reshape(-1, 3)).equations
    E = np.vstack([-planes[:, :3].T, planes[:, 3]])
    u, _ = nnls(E, np.array([0.0, 0.0, 0.0, 1.0]))
    residual = E @ u - np.array([0.0, 0.0, 0.0, 1.0])
    return float(np.linalg.norm(residual[:3] / residual[3]))


if __name__ == "__main__":
    main("agreement", run)
