"""Plans that are said to be the best are: whatever costs are, of actions in a row, beside those of other actions."""

import pytest

from tamp.planning import Problem, solve
from tamp.planning.pddlstream import from_gen_fn, from_stream_map
from tests.planning.test_problems import ALGORITHMS

DOMAIN = """
(define (domain ways)
  (:requirements :strips :action-costs)
  (:predicates (Road ?p ?q) (At ?p))
  (:functions (total-cost) (Length ?p ?q))
  (:action go
    :parameters (?p ?q) :precondition (and (Road ?p ?q) (At ?p))
    :effect (and (At ?q) (not (At ?p)) (increase (total-cost) (Length ?p ?q)))))
"""

OFFER = """
(define (domain offer)
  (:predicates (Thing ?o) (Offer ?o ?c) (Price ?c) (Bought ?o))
  (:functions (total-cost) (Amount ?c))
  (:action buy
    :parameters (?o ?c) :precondition (Offer ?o ?c)
    :effect (and (Bought ?o) (increase (total-cost) (Amount ?c)))))
"""

OFFERS = """
(define (stream offer)
  (:stream ask :inputs (?o) :domain (Thing ?o) :outputs (?c) :certified (and (Price ?c) (Offer ?o ?c)))
  (:function (Amount ?c) (Price ?c)))
"""


def ways(scale):
    """From 0 to 5 by five short roads, or by one that is a little shorter than all of them."""
    lengths = {**{(i, i + 1): 0.9 * scale for i in range(5)}, (0, 5): 4.1 * scale}
    init = [("At", 0), *(("Road", *road) for road in lengths)]
    init += [("=", ("Length", *road), length) for road, length in lengths.items()]
    return Problem(DOMAIN, None, {}, init, ("At", 5))


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 1e9])
@pytest.mark.parametrize("search", ["ff", "builtin"])
def test_few_dear_actions_are_told_from_many_cheap_ones(search, scale):
    solution = solve(ways(scale), success_cost=0.0, timeout=20.0, search=search)
    assert solution.status == "solved" and solution.report.message == "No better plan exists."
    assert solution.cost == pytest.approx(4.1 * scale)


def offers(scale):
    """Two things, for each of which there are five offers, far apart."""
    stream_map = {
        "ask": from_gen_fn(lambda thing: ((price * scale,) for price in (1e12, 1e9, 3e6, 1e7, 2e5))),
        "Amount": float,
    }
    goal = ("and", ("Bought", "a"), ("Bought", "b"))
    return Problem(OFFER, OFFERS, from_stream_map(stream_map), [("Thing", "a"), ("Thing", "b")], goal)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("scale", [1e-12, 1.0])
def test_costs_of_all_sizes(scale, algorithm):
    assert solve(offers(scale), algorithm=algorithm, success_cost=0.0).cost == pytest.approx(4e5 * scale)
    assert solve(offers(scale), algorithm=algorithm, success_cost=0.0, max_cost=1e15).cost == pytest.approx(4e5 * scale)
    assert solve(offers(scale), algorithm=algorithm, max_cost=1e7 * scale).cost <= 1e7 * scale
    assert solve(offers(scale), algorithm=algorithm, max_cost=3e5 * scale).status == "infeasible"
