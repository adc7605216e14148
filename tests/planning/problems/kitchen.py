"""Cook and clean: objects go to the sink and then to the stove, with grasps that may be held in one of two hands."""

from collections.abc import Iterator
from typing import Any

from tamp.planning import Problem

DOMAIN = """
(define (domain kitchen)
  (:requirements :strips :equality)
  (:constants @sink @stove)
  (:predicates (Arm ?a) (Stackable ?o ?r) (Type ?r ?t) (Grasp ?o ?g) (Pose ?o ?p) (Supported ?o ?p ?r)
               (Kin ?a ?o ?p ?g ?q) (AtPose ?o ?p) (AtGrasp ?a ?o ?g) (HandEmpty ?a)
               (Cleaned ?o) (Cooked ?o) (On ?o ?r) (Holding ?a ?o) (CFree ?o ?p ?o2 ?p2) (Blocked ?o ?p))
  (:action pick
    :parameters (?a ?o ?p ?g ?q)
    :precondition (and (Kin ?a ?o ?p ?g ?q) (AtPose ?o ?p) (HandEmpty ?a))
    :effect (and (AtGrasp ?a ?o ?g) (not (AtPose ?o ?p)) (not (HandEmpty ?a))))
  (:action place
    :parameters (?a ?o ?p ?g ?q)
    :precondition (and (Kin ?a ?o ?p ?g ?q) (AtGrasp ?a ?o ?g) (not (Blocked ?o ?p)))
    :effect (and (AtPose ?o ?p) (HandEmpty ?a) (not (AtGrasp ?a ?o ?g))))
  (:action clean
    :parameters (?o ?r)
    :precondition (and (Stackable ?o ?r) (Type ?r @sink) (On ?o ?r))
    :effect (Cleaned ?o))
  (:action cook
    :parameters (?o ?r)
    :precondition (and (Stackable ?o ?r) (Type ?r @stove) (On ?o ?r) (Cleaned ?o))
    :effect (and (Cooked ?o) (not (Cleaned ?o))))
  (:derived (On ?o ?r) (exists (?p) (and (Supported ?o ?p ?r) (AtPose ?o ?p))))
  (:derived (Holding ?a ?o) (exists (?g) (and (Arm ?a) (Grasp ?o ?g) (AtGrasp ?a ?o ?g))))
  (:derived (Blocked ?o ?p)
    (exists (?o2 ?p2) (and (Pose ?o ?p) (Pose ?o2 ?p2) (AtPose ?o2 ?p2) (not (= ?o ?o2))
                           (not (CFree ?o ?p ?o2 ?p2))))))
"""

STREAMS = """
(define (stream kitchen)
  (:stream sample-grasp :inputs (?o) :domain (Graspable ?o) :outputs (?g) :certified (Grasp ?o ?g))
  (:stream sample-pose
    :inputs (?o ?r) :domain (Stackable ?o ?r) :outputs (?p) :certified (and (Pose ?o ?p) (Supported ?o ?p ?r)))
  (:stream inverse-kinematics
    :inputs (?a ?o ?p ?g)
    :domain (and (Arm ?a) (Pose ?o ?p) (Grasp ?o ?g))
    :outputs (?q)
    :certified (Kin ?a ?o ?p ?g ?q))
  (:stream test-cfree
    :inputs (?o ?p ?o2 ?p2) :domain (and (Pose ?o ?p) (Pose ?o2 ?p2)) :certified (CFree ?o ?p ?o2 ?p2)))
"""


def sample_grasp(context: Any, thing: str) -> Iterator[tuple[str, str]]:
    for side in ("top", "left", "right"):
        yield (thing, side)


def sample_pose(context: Any, thing: str, region: str) -> Iterator[tuple[str, float]]:
    while True:
        yield (region, round(float(context.rng.uniform(0, context.scene[region])), 3))


def inverse_kinematics(
    context: Any, arm: str, thing: str, pose: tuple[str, float], grasp: tuple[str, str]
) -> Iterator[Any]:
    """Each arm reaches only grasps of its own side, or from the top; few tries succeed at once."""
    while grasp[1] in (arm, "top"):
        yield (arm, pose, grasp[1]) if context.rng.random() < 0.5 else None


def collision_free(thing: str, pose: tuple[str, float], thing2: str, pose2: tuple[str, float]) -> bool:
    return thing == thing2 or pose[0] != pose2[0] or abs(pose[1] - pose2[1]) >= 1.0


def test_cfree(context: Any, *args: Any) -> bool:
    return collision_free(*args)


def cook(n: int) -> Problem:
    """n things on the table, of which the first is to be cooked, and the last is to be clean and held."""
    things = [f"food{i}" for i in range(n)]
    size = {"table": 4.0 + 2 * n, "basin": 1.5, "hob": 1.5}
    init: list[Any] = [("Type", "basin", "sink"), ("Type", "hob", "stove")]
    for arm in ("left", "right"):
        init += [("Arm", arm), ("HandEmpty", arm)]
    for i, thing in enumerate(things):
        pose = ("table", float(i))
        init += [
            ("Graspable", thing),
            ("Pose", thing, pose),
            ("AtPose", thing, pose),
            ("Supported", thing, pose, "table"),
        ]
        init += [("Stackable", thing, region) for region in size]
    goal: Any = ("Cooked", things[0])
    if n > 1:
        goal = ("and", goal, ("Cleaned", things[-1]), ("exists", ("?a",), ("Holding", "?a", things[-1])))
    samplers = {
        "sample-grasp": sample_grasp,
        "sample-pose": sample_pose,
        "inverse-kinematics": inverse_kinematics,
        "test-cfree": test_cfree,
    }
    constants = {"@sink": "sink", "@stove": "stove"}
    return Problem(
        domain=DOMAIN, streams=STREAMS, samplers=samplers, init=init, goal=goal, scene=size, constants=constants
    )
