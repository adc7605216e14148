"""Where time is over, conditions that no values fit are named: a stream certifies too little, or in the wrong order."""

from itertools import count

import pytest

from tamp.planning import Problem, solve
from tests.planning.test_problems import ALGORITHMS

DOMAIN = """
(define (domain line)
  (:predicates (Conf ?q) (Block ?b) (Pose ?p) (Kin ?q ?p) (Goal ?p)
               (AtPose ?b ?p) (AtConf ?q) (Holding ?b) (HandEmpty) (In ?b))
  (:action move
    :parameters (?q1 ?q2)
    :precondition (and (Conf ?q1) (Conf ?q2) (AtConf ?q1)) :effect (and (AtConf ?q2) (not (AtConf ?q1))))
  (:action pick
    :parameters (?b ?p ?q)
    :precondition (and (Block ?b) (Kin ?q ?p) (AtConf ?q) (AtPose ?b ?p) (HandEmpty))
    :effect (and (Holding ?b) (not (AtPose ?b ?p)) (not (HandEmpty))))
  (:action place
    :parameters (?b ?p ?q)
    :precondition (and (Block ?b) (Goal ?p) (Kin ?q ?p) (AtConf ?q) (Holding ?b))
    :effect (and (AtPose ?b ?p) (HandEmpty) (not (Holding ?b)) (In ?b))))
"""


def line(pose="(and (Pose ?p) (Goal ?p))", kin="(and (Conf ?q) (Kin ?q ?p))", conf=lambda pose: f"at {pose}", poses=0):
    """A block to be moved along a line, with what the streams certify."""
    return Problem(
        domain=DOMAIN,
        streams=f"""(define (stream line)
  (:stream sample-pose :inputs () :domain () :outputs (?p) :certified {pose})
  (:stream inverse-kinematics :inputs (?p) :domain (Pose ?p) :outputs (?q) :certified {kin}))""",
        samplers={
            "sample-pose": lambda context: count(0.0, 2.0),
            "inverse-kinematics": lambda context, p: iter([conf(p)]),
        },
        init=[("Pose", 5.0 + i) for i in range(poses)]
        + [("Conf", -1.0), ("AtConf", -1.0), ("HandEmpty",), ("Block", "a"), ("Pose", 4.5), ("AtPose", "a", 4.5)],
        goal=("In", "a"),
    )


@pytest.mark.parametrize(
    ("streams", "named"),
    [
        ({"kin": "(and (Conf ?q) (Kin ?p ?q))"}, "(kin ?q ?p) and (atpose ?b ?p) of pick"),
        ({"kin": "(Kin ?q ?p)"}, "(kin ?q ?p) and (atconf ?q) of pick"),
        ({"pose": "(Goal ?p)"}, "(goal ?p) and (kin ?q ?p) of place"),
    ],
)
@pytest.mark.parametrize("algorithm", ["adaptive", "incremental"])
def test_what_no_values_fit_is_named(streams, named, algorithm):
    solution = solve(line(**streams), algorithm=algorithm, timeout=0.5)
    assert solution.status == "timeout"
    assert f"nothing fits {named}" in solution.report.message


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_nothing_is_named_where_values_fit(algorithm):
    assert solve(line(), algorithm=algorithm, timeout=20.0).status == "solved"


def test_nothing_is_told_where_values_of_different_streams_are_equal():
    solution = solve(line(conf=lambda pose: pose, kin="(Kin ?q ?p)"), timeout=0.5)
    assert solution.status == "timeout"
    assert "nothing fits" not in solution.report.message


def test_nothing_is_told_where_what_is_given_was_not_taken_in_yet():
    solution = solve(line(poses=20_000), timeout=0.02)
    assert solution.status == "timeout"
    assert "nothing fits" not in solution.report.message
