"""Out of reach: endless streams do not keep a problem open that they cannot help, and no other is closed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tamp.errors import DomainWarning
from tamp.planning import Certified, Problem, StreamInfo, solve
from tamp.planning.wrappers import from_stream_map
from tests.planning.oracles.exhaustive import search
from tests.planning.problems import chance
from tests.planning.problems.unsolvable import DOMAIN, STREAMS, in_reach, out_of_reach, three_grasps
from tests.planning.test_problems import ALGORITHMS, check
from tests.planning.turns import in_turn

PICK_AND_PLACE = """
(define (domain table)
  (:requirements :strips)
  (:predicates (Block ?b) (Grasp ?b ?g) (Pose ?b ?p) (InGoal ?b ?p) (Kin ?b ?p ?g ?q) (AtPose ?b ?p) (Held ?b ?g)
               (HandEmpty) (Done ?b))
  (:action pick
    :parameters (?b ?p ?g ?q)
    :precondition (and (Kin ?b ?p ?g ?q) (AtPose ?b ?p) (HandEmpty))
    :effect (and (Held ?b ?g) (not (AtPose ?b ?p)) (not (HandEmpty))))
  (:action place
    :parameters (?b ?p ?g ?q)
    :precondition (and (Kin ?b ?p ?g ?q) (Held ?b ?g))
    :effect (and (AtPose ?b ?p) (HandEmpty) (not (Held ?b ?g))))
  (:derived (Done ?b) (exists (?p) (and (InGoal ?b ?p) (AtPose ?b ?p)))))
"""
SAMPLERS = """
(define (stream table)
  (:stream grasps :inputs (?b) :domain (Block ?b) :outputs (?g) :certified (Grasp ?b ?g))
  (:stream poses :inputs (?b) :domain (Block ?b) :outputs (?p) :certified (and (Pose ?b ?p) (InGoal ?b ?p)))
  (:stream kinematics
    :inputs (?b ?p ?g) :domain (and (Pose ?b ?p) (Grasp ?b ?g)) :outputs (?q) :certified (Kin ?b ?p ?g ?q)))
"""


def endless(context, block):
    while True:
        yield float(context.rng.random())


def table(poses=endless, fresh=True):
    """Two blocks; the second cannot be reached where it stands, by neither of its two grasps."""
    init = [("HandEmpty",)]
    for block in ("red", "blue"):
        init += [("Block", block), ("Pose", block, f"start of {block}"), ("AtPose", block, f"start of {block}")]

    def kinematics(context, block, pose, grasp):
        if pose != "start of blue":
            yield (block, pose, grasp)

    return Problem(
        domain=PICK_AND_PLACE,
        streams=SAMPLERS,
        samplers={"grasps": lambda context, block: [1, 2], "poses": poses, "kinematics": kinematics},
        init=init,
        goal=("and", ("Done", "red"), ("Done", "blue")),
        info={"poses": StreamInfo(fresh=fresh)},
    )


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_poses_without_end_do_not_make_up_for_grasps_that_fail(algorithm):
    solution = solve(table(), algorithm=algorithm, timeout=20.0)
    assert solution.status == "infeasible"
    assert solution.report.message == "(done blue) is out of reach, whatever streams may still give."


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_poses_without_end_do_not_make_up_for_grasps_that_were_given_up_but_that_is_no_proof(algorithm):
    problem = replace(table(), info={"poses": StreamInfo(fresh=True), "kinematics": StreamInfo(complete=False)})
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "failed"
    assert "(done blue) is out of reach of all that streams may still give; kinematics gave up" in (
        solution.report.message
    )


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_predicate_that_never_holds_of_poses_without_end_does_not_keep_the_problem_open(algorithm):
    """It was asked of each new pose, as it had not shown whether it certifies more than it promises."""
    blocks = table(fresh=False)
    problem = Problem(
        domain=PICK_AND_PLACE.replace("(Done ?b))\n", "(Done ?b) (Wet ?b ?p))\n", 1).replace(
            "(AtPose ?b ?p) (HandEmpty))", "(AtPose ?b ?p) (HandEmpty) (not (Wet ?b ?p)))", 1
        ),
        streams=SAMPLERS.rstrip()[:-1] + "(:predicate (Wet ?b ?p) (Pose ?b ?p)))",
        samplers={**blocks.samplers, **from_stream_map({"Wet": lambda block, pose: False})},
        init=blocks.init,
        goal=("Held", "blue", 1),
    )
    assert solve(problem, algorithm=algorithm, timeout=3.0).status == "infeasible"


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_stream_that_may_name_known_objects_keeps_the_problem_open(algorithm):
    def late(context, block):
        for _ in range(30):
            yield None
        yield f"start of {block}"

    solution = solve(table(late, fresh=False), algorithm=algorithm, timeout=20.0)
    assert solution.status == "solved"
    assert solve(table(fresh=False), algorithm=algorithm, timeout=0.5).status == "timeout"


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_streams_that_have_nothing_to_do_with_the_goal(algorithm):
    noise = STREAMS.replace(
        "(define (stream reach)", "(define (stream reach) (:stream noise :outputs (?n) :certified (N ?n))"
    )

    def numbers(context):
        while True:
            yield float(context.rng.random())

    problem = Problem(
        domain=DOMAIN.replace("(Thing ?x)", "(Thing ?x) (N ?n)"),
        streams=noise,
        samplers={"sample-grasp": three_grasps, "inverse-kinematics": out_of_reach, "noise": numbers},
        init=[("Thing", "cup"), ("HandEmpty",)],
        goal=("Held", "cup"),
    )
    assert solve(problem, algorithm=algorithm, timeout=20.0).status == "infeasible"


MAKE = """(define (stream reach)
  (:stream make :outputs (?x) :certified (Thing ?x))"""


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_an_object_that_nothing_knows_is_named(algorithm):
    samplers = {"sample-grasp": endless, "inverse-kinematics": in_reach}
    problem = Problem(DOMAIN, STREAMS, samplers, [("Thing", "cup"), ("HandEmpty",)], ("Held", "mug"))
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "infeasible"
    assert "exhausted" not in solution.report.message
    assert "The goal names 'mug', which no fact names and no stream has given." in solution.report.message


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_an_object_that_a_stream_may_yet_give_keeps_the_problem_open(algorithm):
    def make(context, last):
        yield from (f"thing {i}" for i in range(12))
        yield from last

    def ask(last, timeout):
        samplers = {
            "sample-grasp": endless,
            "inverse-kinematics": in_reach,
            "make": lambda context: make(context, last),
        }
        streams = STREAMS.replace("(define (stream reach)", MAKE)
        return solve(
            Problem(DOMAIN, streams, samplers, [("HandEmpty",)], ("Held", "mug")), algorithm=algorithm, timeout=timeout
        )

    assert ask(["mug"], 20.0).status == "solved"
    assert ask(iter(lambda: None, 0), 0.3).status == "timeout"


def test_a_sampler_that_certifies_more_than_it_promises_keeps_the_problem_open():
    def generous(context, block):
        yield Certified(0.5, facts=(("Kin", block, "start of red", 1, "q"),))
        yield from [None] * 40
        yield Certified(0.7, facts=(("Kin", "blue", "start of blue", 1, "q"), ("Kin", "blue", 0.7, 1, "q")))

    assert solve(table(generous), timeout=20.0).status == "solved"


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_test_that_certifies_more_where_it_holds_keeps_the_problem_open(algorithm):
    def wet(context, block, pose):
        kin = tuple(("Kin", "blue", "start of blue", grasp, "q") for grasp in (1, 2))
        return Certified((), kin) if isinstance(pose, float) and pose > 0.97 else False

    blocks = table(fresh=False)
    problem = replace(
        blocks,
        streams=SAMPLERS.rstrip()[:-1] + "(:stream wet :inputs (?b ?p) :domain (Pose ?b ?p) :certified (Block ?b)))",
        samplers={**blocks.samplers, "wet": wet},
        goal=("Held", "blue", 1),
    )
    assert solve(problem, algorithm=algorithm, timeout=20.0).status == "solved"


@in_turn(12)
def test_nothing_is_called_infeasible_that_has_a_plan(seed, algorithm):
    """Streams that never end, though they have no more to give than those of the same problem that do."""
    solution = solve(chance.problem(seed, streams=True, endless=True), algorithm=algorithm, timeout=1.0, seed=0)
    finite = chance.problem(seed, streams=True)
    if solution.plan is not None:
        check(finite, solution)
    elif solution.status == "infeasible":
        assert search(finite, rounds=5, calls=3, limit=300)[0] is None


def wiping(streams="(Spot ?b)", init=("Spot", "s")):
    """Spots are wiped by motions, beside blocks on a table for which there is always more to sample."""
    pddl = PICK_AND_PLACE.replace("(Done ?b))\n", "(Done ?b) (Spot ?b) (WipeMotion ?b ?m) (Wiped ?b))\n", 1)
    wipe = "(:action wipe :parameters (?b ?m) :precondition (WipeMotion ?b ?m) :effect (Wiped ?b))\n"
    more = f"(:stream wipes :inputs (?b) :domain {streams} :outputs (?m) :certified (WipeMotion ?b ?m))\n"
    blocks = table()
    return Problem(
        domain=pddl.replace("(:action pick", wipe + "(:action pick"),
        streams=SAMPLERS.replace("(:stream poses", more + "(:stream poses"),
        samplers={**blocks.samplers, "wipes": lambda context, spot: [1]},
        init=[*blocks.init, init],
        goal=("Wiped", "s"),
        info={"poses": StreamInfo(fresh=True)},
    )


def test_what_waits_for_facts_that_nothing_gives_is_out_of_reach_and_they_are_named():
    with pytest.warns(DomainWarning, match="names 'spott'"):
        solution = solve(wiping(streams="(Spott ?b)"), timeout=60.0)
    said = "(wiped s) is out of reach, whatever streams may still give: nothing gives spott."
    assert (solution.status, solution.report.message) == ("infeasible", said)
    assert solve(wiping(init=("Block", "s")), timeout=60.0).report.message == said.replace("spott", "spot")
    assert solve(wiping(), timeout=60.0).plan is not None
