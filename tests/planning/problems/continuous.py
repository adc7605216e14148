"""Continuous pick and place on a line and on a plane: square blocks of width 1, regions as intervals and rectangles.

Poses and configurations are numpy arrays, which have no hash. In PDDLStream's tutorial's form.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from tamp.planning import Problem

DOMAIN = """
(define (domain pick-and-place)
  (:requirements :strips :equality)
  (:predicates (Block ?b) (Region ?r) (Placeable ?b ?r) (Conf ?q) (Pose ?b ?p) (Traj ?t) (Kin ?b ?q ?p)
               (Motion ?q1 ?t ?q2) (Contained ?b ?p ?r) (CFree ?b1 ?p1 ?b2 ?p2)
               (AtConf ?q) (AtPose ?b ?p) (Holding ?b) (HandEmpty) (CanMove)
               (In ?b ?r) (UnsafePose ?b ?p))
  (:action move
    :parameters (?q1 ?t ?q2)
    :precondition (and (Motion ?q1 ?t ?q2) (AtConf ?q1) (CanMove))
    :effect (and (AtConf ?q2) (not (AtConf ?q1)) (not (CanMove))))
  (:action pick
    :parameters (?b ?p ?q)
    :precondition (and (Kin ?b ?q ?p) (AtConf ?q) (AtPose ?b ?p) (HandEmpty))
    :effect (and (Holding ?b) (CanMove) (not (AtPose ?b ?p)) (not (HandEmpty))))
  (:action place
    :parameters (?b ?p ?q)
    :precondition (and (Kin ?b ?q ?p) (AtConf ?q) (Holding ?b) (not (UnsafePose ?b ?p)))
    :effect (and (AtPose ?b ?p) (HandEmpty) (CanMove) (not (Holding ?b))))
  (:derived (In ?b ?r) (exists (?p) (and (Contained ?b ?p ?r) (AtPose ?b ?p))))
  (:derived (UnsafePose ?b1 ?p1)
    (exists (?b2 ?p2) (and (Pose ?b1 ?p1) (Pose ?b2 ?p2) (not (= ?b1 ?b2))
                           (AtPose ?b2 ?p2) (not (CFree ?b1 ?p1 ?b2 ?p2))))))
"""

UNSAFE = "(not (UnsafePose ?b ?p))"

FORALL = "(forall (?b2 ?p2) (imply (and (AtPose ?b2 ?p2) (not (= ?b ?b2))) (CFree ?b ?p ?b2 ?p2)))"
"""Instead of UNSAFE: collisions as a quantified precondition."""

EFFECT = """
(forall (?r) (when (Contained ?b ?p ?r) (Inside ?b ?r)))
(forall (?b2 ?p2) (when (and (AtPose ?b2 ?p2) (not (= ?b ?b2)) (not (CFree ?b ?p ?b2 ?p2))) (not (Safe))))
"""
"""Instead of UNSAFE and the axiom of In: what a placement brings about depends on what streams certified of it."""


def conditional_effects() -> str:
    """The domain with conditional effects where the other has axioms."""
    text = DOMAIN.replace(UNSAFE, "(Safe)").replace("(UnsafePose ?b ?p))", "(Inside ?b ?r) (Safe))", 1)
    text = text.replace(
        "(In ?b ?r) (exists (?p) (and (Contained ?b ?p ?r) (AtPose ?b ?p)))", "(In ?b ?r) (Inside ?b ?r)"
    )
    text = text.replace(
        "(AtPose ?b ?p) (HandEmpty) (CanMove) (not (Holding ?b))",
        "(AtPose ?b ?p) (HandEmpty) (CanMove) (not (Holding ?b))" + EFFECT,
    )
    text = text.replace("(not (HandEmpty)))", "(not (HandEmpty)) (forall (?r) (not (Inside ?b ?r))))")
    return text[: text.index("(:derived (UnsafePose")] + ")"


def wrecking_effects() -> str:
    """As `conditional_effects`, where a collision brings about what bars actions instead of ending what allows them."""
    text = conditional_effects().replace("(not (Safe))", "(Wrecked)").replace("(Safe))\n", "(Wrecked))\n", 1)
    text = text.replace("(Holding ?b) (Safe))", "(Holding ?b) (not (Wrecked)))")
    return text.replace("(AtConf ?q1) (CanMove))", "(AtConf ?q1) (CanMove) (not (Wrecked)))")


STREAMS = """
(define (stream pick-and-place)
  (:stream sample-pose
    :inputs (?b ?r)
    :domain (Placeable ?b ?r)
    :outputs (?p)
    :certified (and (Pose ?b ?p) (Contained ?b ?p ?r)))
  (:stream inverse-kinematics
    :inputs (?b ?p)
    :domain (Pose ?b ?p)
    :outputs (?q)
    :certified (and (Conf ?q) (Kin ?b ?q ?p)))
  (:stream plan-motion
    :inputs (?q1 ?q2)
    :domain (and (Conf ?q1) (Conf ?q2))
    :outputs (?t)
    :certified (and (Traj ?t) (Motion ?q1 ?t ?q2)))
  (:stream test-cfree
    :inputs (?b1 ?p1 ?b2 ?p2)
    :domain (and (Pose ?b1 ?p1) (Pose ?b2 ?p2))
    :certified (CFree ?b1 ?p1 ?b2 ?p2)))
"""

Array = np.ndarray[Any, Any]
Bounds = tuple[Array, Array]
"""Lower and upper corner of a region."""


def sample_pose(context: Any, block: str, region: str) -> Iterator[Array]:
    lower, upper = context.scene[region]
    while True:
        yield context.rng.uniform(lower + 0.5, upper - 0.5)


def inverse_kinematics(context: Any, block: str, pose: Array) -> Iterator[Array]:
    yield pose + np.eye(len(pose))[-1]


def plan_motion(context: Any, start: Array, end: Array) -> Iterator[Array]:
    yield np.linspace(start, end, 3)


def collision_free(block1: str, pose1: Array, block2: str, pose2: Array) -> bool:
    return block1 == block2 or bool(np.max(np.abs(pose1 - pose2)) >= 1.0)


def test_cfree(context: Any, *args: Any) -> bool:
    return collision_free(*args)


SAMPLERS = {
    "sample-pose": sample_pose,
    "inverse-kinematics": inverse_kinematics,
    "plan-motion": plan_motion,
    "test-cfree": test_cfree,
}


def overlaps(facts: dict[str, Any]) -> list[tuple[str, str]]:
    """Pairs of blocks that stand in each other, by the poses in a state's facts."""
    at = [(block.value, pose.value) for block, pose in facts.get("atpose", ())]
    return [(a, b) for a, p in at for b, q in at if str(a) < str(b) and not collision_free(a, p, b, q)]


def line(n: int, domain: str = DOMAIN) -> Problem:
    """n blocks side by side from 0 on; all must come into the region from -2n - 2 to -1."""
    table = (np.array([-1.0]), np.array([n + 1.0]))
    goal = (np.array([-2.0 * n - 2.0]), np.array([-1.0]))
    return _problem(np.arange(n, dtype=float)[:, None] + 0.5, {"table": table, "goal": goal}, n, domain=domain)


def plane(n: int) -> Problem:
    """n blocks on a grid of three columns; all must come into a square of twice their area at the side."""
    starts = np.array([[i % 3 + 0.5, i // 3 + 0.5] for i in range(n)])
    side = max(2.0, 2.0 * np.sqrt(n))
    regions = {
        "table": (np.zeros(2), np.array([3.0, n // 3 + 1.0])),
        "goal": (np.array([10.0, 0.0]), np.array([10.0 + side, side])),
    }
    return _problem(starts, regions, n)


def occupied(n: int) -> Problem:
    """On a line, the first block's goal is so short that the others, which stand in it, must leave first."""
    starts = np.array([[5.0], *([10.0 + 1.1 * i] for i in range(n - 1))])
    regions = {
        "goal": (np.array([9.5]), np.array([9.5 + 1.1 * (n - 1)])),
        "table": (np.array([-10.0 - 3.0 * n]), np.array([0.0])),
    }
    return _problem(starts, regions, 1, everywhere=True)


def _problem(
    starts: Array, regions: dict[str, Bounds], moved: int, everywhere: bool = False, domain: str = DOMAIN
) -> Problem:
    home = np.zeros(starts.shape[1])
    blocks = [f"block{i}" for i in range(len(starts))]
    init: list[Any] = [("HandEmpty",), ("CanMove",), ("Safe",), ("Conf", home), ("AtConf", home)]
    init += [("Region", region) for region in regions]
    for block, start in zip(blocks, starts, strict=True):
        init += [("Block", block), ("Pose", block, start), ("AtPose", block, start)]
        init += [("Placeable", block, region) for region in regions if everywhere or region == "goal"]
    goal: Any = ("and", *(("In", block, "goal") for block in blocks[:moved]))
    if "(Safe)" in domain:
        goal = ("and", ("Safe",), goal)
    if "(Wrecked)" in domain:
        init.remove(("Safe",))
        goal = ("and", ("not", ("Wrecked",)), ("AtConf", home), goal)
    return Problem(domain=domain, streams=STREAMS, samplers=SAMPLERS, init=init, goal=goal, scene=regions)
