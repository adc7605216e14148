"""What a goal cannot need is told by regression from it, whatever is grounded yet."""

import pytest

from tamp import clock
from tamp.planning import Problem, solve
from tamp.planning.algorithms.session import Session
from tamp.planning.grounding.relevance import Relevance
from tamp.planning.options import Options
from tamp.planning.search.fast_downward import FastDownward
from tests.planning.problems import clearing
from tests.planning.test_problems import ALGORITHMS, check

DOMAIN = """
(define (domain table)
  (:predicates (Block ?b) (Grasp ?b ?g) (Pose ?b ?p) (Spot ?p) (InGoal ?b ?p) (Kin ?b ?p ?g ?q) (Near ?p ?r)
               (AtPose ?b ?p) (Held ?b ?g) (HandEmpty) (Done ?b) (Blocked ?p))
  (:functions (Far ?p))
  (:action pick
    :parameters (?b ?p ?g ?q)
    :precondition (and (Kin ?b ?p ?g ?q) (AtPose ?b ?p) (HandEmpty))
    :effect (and (Held ?b ?g) (not (AtPose ?b ?p)) (not (HandEmpty)) (increase (total-cost) 1)))
  (:action place
    :parameters (?b ?p ?g ?q)
    :precondition (and (Kin ?b ?p ?g ?q) (Held ?b ?g) {free})
    :effect (and (AtPose ?b ?p) (HandEmpty) (not (Held ?b ?g)) (increase (total-cost) (Far ?p))))
  (:derived (Done ?b) (exists (?p) (and (InGoal ?b ?p) (AtPose ?b ?p))))
  (:derived (Blocked ?p) (exists (?o ?r) (and (Near ?p ?r) (AtPose ?o ?r)))))
"""
STREAMS = """
(define (stream table)
  (:stream grasps :inputs (?b) :domain (Block ?b) :outputs (?g) :certified (Grasp ?b ?g))
  (:stream poses :inputs (?b) :domain (Block ?b) :outputs (?p) :certified (and (Pose ?b ?p) (Spot ?p) (InGoal ?b ?p)))
  (:stream kinematics
    :inputs (?b ?p ?g) :domain (and (Pose ?b ?p) (Grasp ?b ?g)) :outputs (?q) :certified (Kin ?b ?p ?g ?q))
  (:stream near :inputs (?p ?r) :domain (and (Spot ?p) (Spot ?r)) :certified (Near ?p ?r))
  (:function (Far ?p) (Spot ?p)))
"""
BLOCKS = ("red", "blue", "grey")


def table(goal=("Done", "red"), crowded=False, asked=None):
    """Blocks that one hand takes and puts down; where it is crowded, one may be in another's way."""

    def noting(sampler):
        def noted(context, block, *others):
            if asked is not None:
                asked.append(block)
            return sampler(block, *others)

        return noted

    return Problem(
        domain=DOMAIN.replace("{free}", "(not (Blocked ?p))" if crowded else ""),
        streams=STREAMS,
        samplers={
            "grasps": noting(lambda block: [1, 2]),
            "poses": noting(lambda block: [f"new of {block}", f"newer of {block}"]),
            "kinematics": noting(lambda block, pose, grasp: [f"{block}, {pose}, {grasp}"]),
            "near": lambda context, p, r: p == r,
            "far": lambda context, p: 2.0 if "newer" in p else 3.0,
        },
        init=[
            ("HandEmpty",),
            *((p, b) for b in BLOCKS for p in ("Block",)),
            *((p, b, f"start of {b}") for b in BLOCKS for p in ("Pose", "AtPose")),
            *(("Spot", f"start of {b}") for b in BLOCKS),
        ],
        goal=goal,
    )


def needed(problem):
    """The blocks of which a goal may need something, among all streams that have come up in some rounds."""
    session = Session(problem, Options(), FastDownward(), True, clock.now())
    session.begin()
    for _ in range(3):
        session.rounds.expand()
    relevance = Relevance(session.schema, session.connectors, session.knowledge)
    found = {"grasps": set(), "poses": set(), "kinematics": set()}
    for instance in session.knowledge.instances():
        if instance.external.name in found:
            block = session.objects.value(instance.inputs[0])
            found[instance.external.name].update({block} if relevance.of(instance) else ())
    assert len(set(map(frozenset, found.values()))) == 1, found
    return found["kinematics"]


def test_other_things_that_would_leave_the_hand_free_again_are_not_needed():
    assert needed(table()) == {"red"}


def test_what_the_goal_says_of_a_thing_is_needed_be_it_true_or_false():
    assert needed(table(("and", ("Done", "red"), ("not", ("AtPose", "blue", "start of blue"))))) == {"red", "blue"}


def test_what_may_be_in_the_way_is_needed_and_must_be_put_somewhere():
    """No goal speaks of blue and grey: one of them would be taken up, and the hand must be free again after that."""
    assert needed(table(crowded=True)) == set(BLOCKS)


def test_what_streams_of_moves_are_told_of_is_needed():
    """No action but the move brings the goal about, and all of them stand in its way."""
    session = Session(clearing.row(4), Options(), FastDownward(), True, clock.now())
    session.begin()
    session.rounds.expand()
    relevance = Relevance(session.schema, session.connectors, session.knowledge)
    assert all(map(relevance.of, session.knowledge.instances()))


@pytest.mark.parametrize("algorithm", [a for a in ALGORITHMS if a != "incremental"])
def test_a_cheaper_plan_is_not_looked_for_with_things_that_no_goal_needs(algorithm):
    asked = []
    problem = table(asked=asked)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    check(problem, solution)
    assert solution.cost == 3.0 and set(asked) == {"red"}
