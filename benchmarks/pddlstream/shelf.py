"""Blocks on a line, as in `shelf`, where an optimizer says what fits, or a test is told what stands in the way."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations
from typing import Any

import numpy as np

from benchmarks.pddlstream.shapes import ABOVE, SHELF, SHELF_STREAMS, WIDTH
from tamp.planning import Problem
from tamp.planning.pddlstream import from_fn, from_gen_fn, from_list_fn, from_stream_map, from_test

OPTIMIZER = """
(define (stream shelf)
  (:stream sample-grip :inputs (?b) :domain (Block ?b) :outputs (?g) :certified (Grip ?b ?g))
  (:optimizer fit
    (:variables (?p)
      :inputs (?b ?s) :domain (MayBe ?b ?s) :graph (and (Pose ?b ?p) (Within ?b ?p ?s)))
    (:variables (?q)
      :inputs (?b ?p ?g) :domain (and (Pose ?b ?p) (Grip ?b ?g)) :graph (and (Conf ?q) (Reach ?b ?q ?p ?g)))
    (:constraint (Apart ?b1 ?p1 ?b2 ?p2) :necessary (and (Pose ?b1 ?p1) (Pose ?b2 ?p2))))
  (:stream plan-path :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :outputs (?t) :certified (Path ?q1 ?t ?q2))
  (:function (Length ?q1 ?q2) (and (Conf ?q1) (Conf ?q2))))
"""


def fit(regions: dict[str, tuple[float, float]]) -> Any:
    """A procedure that puts blocks side by side from the left: it has one answer to a question, or none."""

    def solve(outputs: Any, facts: Any, hint: Any = None) -> list[tuple[np.ndarray, ...]]:
        values: dict[str, np.ndarray] = {}
        within = {f[2]: regions[f[3]] for f in facts if f[0] == "within" and f[2] in outputs}
        apart = [(f[2], f[4]) for f in facts if f[0] == "apart"]
        for order in permutations(within):
            values = {}
            for name in order:
                low, high = within[name]
                others = [b if isinstance(b, np.ndarray) else values.get(b) for a, b in apart if _is(a, name)]
                others += [a if isinstance(a, np.ndarray) else values.get(a) for a, b in apart if _is(b, name)]
                taken = sorted(float(other[0]) for other in others if other is not None)
                x = low + WIDTH / 2
                for other in taken:
                    x = other + 1.01 * WIDTH if abs(x - other) <= WIDTH else x
                if x > high - WIDTH / 2:
                    break
                values[name] = np.array([x, 0.0])
            else:
                break
        else:
            return []
        for fact in facts:
            if fact[0] == "reach" and fact[2] in outputs:
                pose = fact[3] if isinstance(fact[3], np.ndarray) else values[fact[3]]
                values[fact[2]] = pose + ABOVE
            if fact[0] == "apart":
                p, q = (v if isinstance(v, np.ndarray) else values[v] for v in (fact[2], fact[4]))
                if abs(p[0] - q[0]) <= WIDTH:
                    return []
        return [tuple(values[name] for name in outputs)]

    return from_list_fn(solve)


def _is(value: Any, name: str) -> bool:
    return isinstance(value, str) and value == name


def optimised(starts: list[float], goals: dict[str, str], regions: dict[str, tuple[float, float]]) -> Problem:
    """Blocks on a line into regions where an optimizer says what fits; its answers are always the same ones."""
    home = np.array([-5.0, 6.0])
    init: list[Any] = [("Arm", 0), ("MayMove", 0), ("Conf", home), ("AtConf", 0, home), ("Empty", 0)]
    for name, start in zip("ABCDEFGH", starts, strict=False):
        pose = np.array([start, 0.0])
        init += [("Block", name), ("Pose", name, pose), ("AtPose", name, pose)]
        init += [("MayBe", name, region) for region in ("floor", goals.get(name, "floor"))]
    stream_map = {
        "sample-grip": from_fn(lambda block: ("top",)),
        "fit": fit(regions),
        "plan-path": from_fn(lambda a, b: ([a, b],)),
        "length": lambda a, b: 10.0 + float(np.abs(a - b).sum()),
    }
    goal = ("and", *(("In", name, region) for name, region in goals.items()))
    return Problem(SHELF, OPTIMIZER, from_stream_map(stream_map), init, goal)


CARRYING = SHELF.replace("(Path ?q1 ?t ?q2)", "(Free ?q1 ?q2)").replace("?a ?q1 ?t ?q2", "?a ?q1 ?q2")

CARRYING_STREAMS = f"""
{SHELF_STREAMS[: SHELF_STREAMS.index("(:stream plan-path")]}
  (:stream test-free
    :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :fluents (AtPose AtGrip) :certified (Free ?q1 ?q2))
  {SHELF_STREAMS[SHELF_STREAMS.index("(:stream test-apart") :]}
"""


CARRIED_STREAMS = f"""
{SHELF_STREAMS[: SHELF_STREAMS.index("(:stream plan-path")]}
  (:stream plan-path
    :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :fluents (AtPose AtGrip)
    :outputs (?t) :certified (Path ?q1 ?t ?q2))
  {SHELF_STREAMS[SHELF_STREAMS.index("(:stream test-apart") :]}
"""


def carrying(
    starts: list[float],
    goals: dict[str, str],
    regions: dict[str, tuple[float, float]],
    seed: int = 0,
    paths: bool = False,
) -> Problem:
    """Blocks are carried at a height at which they hit tall ones, which stand at odd places: a test told the state.

    `paths`: a stream that is told the state gives a path in place of the test.
    """
    home = np.array([-9.0, 6.0])
    init: list[Any] = [("Arm", 0), ("MayMove", 0), ("Conf", home), ("AtConf", 0, home), ("Empty", 0)]
    tall = {name for name in "ABCDEFGH"[: len(starts)] if name not in goals}
    for name, start in zip("ABCDEFGH", starts, strict=False):
        pose = np.array([start, 0.0])
        init += [("Block", name), ("Pose", name, pose), ("AtPose", name, pose), ("MayBe", name, "floor")]
        init += [("MayBe", name, goals[name])] if name in goals else []
    rng = np.random.default_rng(seed)

    def sample_pose(block: str, region: str) -> Iterator[tuple[np.ndarray]]:
        low, high = regions[region]
        while True:
            yield (np.array([rng.uniform(low + WIDTH / 2, high - WIDTH / 2), 0.0]),)

    def free(a: np.ndarray, b: np.ndarray, fluents: Any = ()) -> bool:
        held = [f for f in fluents if f[0].lower() == "atgrip"]
        low, high = sorted((float(a[0]), float(b[0])))
        standing = [f for f in fluents if f[0].lower() == "atpose" and f[1] in tall]
        return not (held and any(low - WIDTH < f[2][0] < high + WIDTH for f in standing))

    def path(a: np.ndarray, b: np.ndarray, fluents: Any = ()) -> tuple[list[np.ndarray]] | None:
        return ([a, b],) if free(a, b, fluents) else None

    stream_map = {
        "sample-grip": from_fn(lambda block: ("top",)),
        "sample-pose": from_gen_fn(sample_pose),
        "inverse-kinematics": from_fn(lambda block, pose, grip: (pose + ABOVE,)),
        **({"plan-path": from_fn(path)} if paths else {"test-free": from_test(free)}),
        "test-apart": from_test(lambda b1, p1, b2, p2: abs(p1[0] - p2[0]) > WIDTH),
        "test-within": from_test(lambda b, p, s: bool(regions[s][0] + WIDTH / 2 <= p[0] <= regions[s][1] - WIDTH / 2)),
        "length": lambda a, b: 10.0 + float(np.abs(a - b).sum()),
    }
    goal = ("and", *(("In", name, region) for name, region in goals.items()))
    domain, streams = (SHELF, CARRIED_STREAMS) if paths else (CARRYING, CARRYING_STREAMS)
    return Problem(domain, streams, from_stream_map(stream_map), init, goal)
