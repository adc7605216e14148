"""Tests that say no to all values of some kind: what a plan under hopes rests on must not be more of that kind."""

from dataclasses import replace

import pytest

from tamp.planning import solve
from tests.planning.problems.ovens import OVEN, OVEN_STREAMS, oven
from tests.planning.test_problems import check

ALGORITHMS = ["adaptive", "binding", "focused"]


def assert_solved(problem, algorithm):
    """Solved at the least cost, with a few searches."""
    solution = solve(problem, algorithm=algorithm, max_iterations=10)
    assert solution.cost == 7, solution.report
    check(problem, solution)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_another_order_is_tried_where_tests_say_no_to_all_values_of_a_kind(algorithm):
    """Both things were put into the oven, which has room for one, again and again in ever new places."""
    assert_solved(oven(2), algorithm)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_so_it_is_where_a_derived_predicate_says_what_is_in_the_way(algorithm):
    condition = "(forall (?o2 ?p2) (imply (and (AtPose ?o2 ?p2) (not (= ?o ?o2))) (Clear ?t ?o2 ?p2)))"
    assert OVEN.count(condition) == 2
    domain = OVEN.replace(condition, "(not (Barred ?o ?t))").replace("(Baked ?o) (In", "(Baked ?o) (Barred ?o ?t) (In")
    barred = "(and (Way ?t) (Thing ?o) (AtPose ?o2 ?p2) (not (= ?o ?o2)) (not (Clear ?t ?o2 ?p2)))"
    domain = domain.rstrip()[:-1] + f"(:derived (Barred ?o ?t) (exists (?o2 ?p2) {barred})))"
    problem = replace(oven(2), domain=domain.replace("(Clear ?t ?o ?p)", "(Clear ?t ?o ?p) (Way ?t)", 1))
    assert_solved(problem, algorithm)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_so_it_is_where_a_predicate_says_what_collides(algorithm):
    problem = oven(2)
    samplers = dict(problem.samplers)
    clear = samplers.pop("test-clear")
    samplers["hits"] = lambda context, way, thing, pose: not clear(context, way, thing, pose)
    streams = OVEN_STREAMS.replace(
        "(:stream test-clear :inputs (?t ?o ?p) :domain (and (Way ?t) (Pose ?o ?p)) :certified (Clear ?t ?o ?p))",
        "(:predicate (Hits ?t ?o ?p) (and (Way ?t) (Pose ?o ?p)))",
    )
    domain = OVEN.replace("(Clear ?t ?o2 ?p2)", "(not (Hits ?t ?o2 ?p2))").replace("(Clear ?t", "(Hits ?t")
    problem = replace(problem, domain=domain, streams=streams, samplers=samplers)
    assert_solved(problem, algorithm)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_values_that_are_rare_are_still_found_where_nothing_else_will_do(algorithm):
    """There is room for both things in one of some 170 pairs of places: what bars their kinds is a guess."""
    goal = ("and", ("In", "thing 0", "oven"), ("In", "thing 1", "oven"))
    problem = replace(oven(2, width=1.3), goal=goal)
    solution = solve(problem, algorithm=algorithm, max_iterations=100)
    assert solution.cost == 4, solution.report
    check(problem, solution)
