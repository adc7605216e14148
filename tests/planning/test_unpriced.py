"""An action whose cost has no value is not possible, as in Fast Downward; with unit costs it needs none."""

import pytest

from tamp.errors import DomainWarning, SamplerError
from tamp.planning import Problem, solve
from tests.planning.test_problems import ALGORITHMS

DOMAIN = """
(define (domain ways)
  (:predicates (Item ?i) (Way ?i ?w) (Paved ?w) (Done ?i))
  (:functions (total-cost) (Price ?w))
  (:action go :parameters (?i ?w) :precondition (Way ?i ?w) :effect (and (Done ?i) (increase (total-cost) (Price ?w)))))
"""
STREAMS = """
(define (stream ways)
  (:stream find-way :inputs (?i) :domain (Item ?i) :outputs (?w) :certified (Way ?i ?w))
  (:function (Price ?w) (Paved ?w)))
"""
WITHOUT = STREAMS.replace("(:function (Price ?w) (Paved ?w))", "")


def ways(streams=STREAMS, init=(), price=lambda context, way: 9.0):
    samplers = {"find-way": lambda context, item: iter([1, 2, 3])}
    if streams is STREAMS:
        samplers["price"] = price
    return Problem(DOMAIN, streams, samplers, [("Item", "a"), *init], ("Done", "a"))


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_way_without_a_given_value_is_not_gone(algorithm):
    """What had no value was taken to cost nothing."""
    solution = solve(ways(WITHOUT, [("=", ("Price", 2), 5)]), algorithm=algorithm, timeout=20.0)
    assert [(a.args, solution.cost) for a in solution.plan] == [(("a", 2), 5.0)]
    assert all(not fact[0].startswith("@") for fact in solution.certified)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(("given", "way", "cost"), [((3, 20), 2, 9.0), ((3, 4), 3, 4.0)])
def test_a_value_is_given_or_asked_for_within_the_domain(algorithm, given, way, cost):
    """One value in init had every other asked for outside of the function's domain, which is an error."""
    problem = ways(init=[("Paved", 2), ("=", ("Price", given[0]), given[1])])
    solution = solve(problem, algorithm=algorithm, success_cost=cost, timeout=20.0)
    assert [(a.args, solution.cost) for a in solution.plan] == [(("a", way), cost)]


def test_without_any_value_there_is_a_warning_and_no_plan():
    with pytest.warns(DomainWarning, match="'go' is never possible: its cost names 'price'"):
        solution = solve(ways(WITHOUT), timeout=20.0)
    assert solution.status == "infeasible"


@pytest.mark.parametrize("streams", [STREAMS, WITHOUT])
def test_with_unit_costs_functions_are_not_looked_at(streams, recwarn):
    solution = solve(ways(streams), unit_costs=True, timeout=20.0)
    assert (len(solution.plan), solution.cost) == (1, 1.0)
    assert not recwarn.list


@pytest.mark.parametrize("value", [None, float("inf"), float("nan"), -1.0])
def test_what_is_no_cost_is_an_error(value):
    problem = ways(init=[("Paved", 1)], price=lambda context, way: value)
    with pytest.raises(SamplerError, match="function 'price': expected a finite number of 0 or more, found"):
        solve(problem, timeout=20.0)
