"""Plans that are said to be the best are: whatever costs are, of actions in a row, beside those of other actions."""

import math
import random

import pytest

from tamp.planning import Problem, solve
from tamp.planning.pddlstream import from_gen_fn, from_stream_map
from tests.planning.test_problems import ALGORITHMS
from tests.planning.turns import in_turn

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


ERRANDS = """
(define (domain errands)
  (:predicates (Thing ?o) (Offer ?o ?c) (Bought ?o) (Place ?p) (Road ?p ?q) (At ?p))
  (:functions (Amount ?c) (Length ?p ?q))
  (:action buy
    :parameters (?o ?c) :precondition (Offer ?o ?c) :effect (and (Bought ?o) (increase (total-cost) (Amount ?c))))
  (:action go
    :parameters (?p ?q) :precondition (and (Road ?p ?q) (At ?p))
    :effect (and (At ?q) (not (At ?p)) (increase (total-cost) (Length ?p ?q)))))
"""

ERRANDS_STREAMS = """
(define (stream errands)
  (:stream ask :inputs (?o) :domain (Thing ?o) :outputs (?c) :certified (Offer ?o ?c))
  (:stream look :inputs (?p) :domain (Place ?p) :outputs (?q) :certified (and (Place ?q) (Road ?p ?q)))
  (:function (Amount ?c) (and))
  (:function (Length ?p ?q) (Road ?p ?q)))
"""


def errands(seed):
    """Things offered at some prices, and a place to go to on roads found on the way; with what that costs at least."""
    rng = random.Random(seed)
    prices = {f"thing{i}": rng.choices([0, 1, 2, 3, 5, 8, 13], k=rng.randint(1, 4)) for i in range(rng.randint(1, 3))}
    lengths = {(a, b): rng.randint(0, 9) for a in range(5) for b in range(5) if a != b and rng.random() < 0.4}
    after = {a: [b for start, b in lengths if start == a] for a in range(5)}
    far = {0: 0}
    for _ in range(5):
        for (a, b), length in lengths.items():
            if a in far:
                far[b] = min(far.get(b, math.inf), far[a] + length)
    stream_map = {
        "ask": from_gen_fn(lambda thing: ((price,) for price in prices[thing])),
        "look": from_gen_fn(lambda place: ((other,) for other in after[place])),
        "amount": float,
        "length": lambda a, b: lengths[a, b],
    }
    init = [("Place", 0), ("At", 0), *(("Thing", thing) for thing in prices)]
    goal = ("and", ("At", 4), *(("Bought", thing) for thing in prices))
    least = sum(map(min, prices.values())) + far.get(4, math.inf)
    return Problem(ERRANDS, ERRANDS_STREAMS, from_stream_map(stream_map), init, goal), least


@in_turn(6)
def test_bounds_of_costs_are_kept_and_proofs_are_proofs(algorithm, seed):
    """Against all ways and all offers: what costs at most so much, what is the cheapest, and that there is nothing."""
    problem, least = errands(seed)
    first = solve(problem, algorithm=algorithm, timeout=20.0)
    if least == math.inf:
        assert first.status == "infeasible"
        return
    assert first.solved and first.cost >= least
    assert solve(problem, algorithm=algorithm, timeout=20.0, max_cost=least).cost == least
    assert solve(problem, algorithm=algorithm, timeout=20.0, success_cost=least).cost == least
    assert solve(problem, algorithm=algorithm, timeout=20.0, max_cost=least - 0.5).status == "infeasible"
