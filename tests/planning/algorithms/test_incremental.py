"""How drawing and searching share the work in the algorithm "incremental", and what is not searched twice."""

from dataclasses import replace
from functools import partial
from itertools import count, pairwise

import numpy as np
import pytest

from benchmarks.pddlstream.shapes import shelf
from benchmarks.pddlstream.small import packing
from tamp.planning import Problem, solve
from tamp.planning.search.best_first import BuiltinSearch

HAND = """
(define (domain hand)
  (:predicates (Place ?p) (Good ?p) (Took) (Empty))
  (:action take :parameters () :precondition (Empty) :effect (and (Took) (not (Empty))))
  (:action put :parameters (?p) :precondition (and (Took) (Good ?p)) :effect (Empty)))
"""

HAND_STREAMS = """
(define (stream hand)
  (:stream sample-place :outputs (?p) :certified (Place ?p))
  (:stream test-good :inputs (?p) :domain (Place ?p) :certified (Good ?p)))
"""


def late():
    """The thirtieth place drawn is the first good one."""
    samplers = {"sample-place": lambda context: count(), "test-good": lambda context, place: place >= 30}
    return Problem(HAND, HAND_STREAMS, samplers, [("Empty",)], ("and", ("Took",), ("Empty",)))


def searches(states):
    """How many searches it takes until the thirtieth place is drawn, where each looks at so many states in vain."""
    found = []

    def search(task, timeout, bound=None, effort=float("inf")):
        result = BuiltinSearch()(task, timeout, bound, effort)
        found.append(result)
        return replace(result, states=states, proven=False) if result.plan is None else result

    solution = solve(late(), algorithm="incremental", search=search, timeout=20.0)
    assert solution.status == "solved"
    return len(found)


def test_more_is_drawn_the_dearer_a_search_in_vain_was():
    """Proving over and over again that few values do not suffice took all the time: five packed blocks timed out."""
    assert searches(states=10**9) <= 10 < 30 <= searches(states=0)


@pytest.mark.parametrize(
    ("problem", "algorithm"),
    [(late, "adaptive"), (late, "focused"), (late, "incremental"), (partial(packing, 2, (3.0, 1.0)), "incremental")],
)
def test_what_was_just_searched_to_its_end_in_vain_is_not_searched_again(problem, algorithm):
    seen = []

    def search(task, timeout, bound=None, effort=float("inf")):
        result = BuiltinSearch()(task, timeout, bound, effort)
        seen.append((task, bound, result.plan is None and result.proven))
        return result

    solution = solve(problem(), algorithm=algorithm, search=search, timeout=20.0)
    assert solution.status == "solved"
    assert any(barren for _, _, barren in seen)
    for (task, bound, barren), (following, its_bound, _) in pairwise(seen):
        assert not barren or (task, bound) != (following, its_bound)


def test_values_that_do_not_go_together_are_not_found_out_a_search_at_a_time():
    """Each search showed of one pair of places that both blocks do not fit: 162 searches."""
    rng = np.random.default_rng(3)
    line = {"floor": (-10.0, 10.0), "goal": (5.0, 10.0)}
    problem = shelf([0.0, -3.0], {"A": "goal", "B": "goal"}, line, rng=rng)
    solution = solve(problem, algorithm="incremental", timeout=20.0, seed=3)
    assert solution.status == "solved"
    assert solution.report.counts["iterations"] <= 60


PAIRS = """
(define (domain pairs)
  (:predicates (Thing ?a) (Key ?k) (Open))
  (:action open :parameters (?k) :precondition (Key ?k) :effect (Open)))
"""

PAIR_STREAMS = """
(define (stream pairs)
  (:stream cut :inputs (?a ?b) :domain (and (Thing ?a) (Thing ?b)) :outputs (?k) :certified (Key ?k)))
"""


def rounds_for_pairs(things):
    """How many searches it takes until a stream is asked for the one pair of so many things that has something."""
    samplers = {"cut": lambda context, a, b: ["key"] if a == b == things - 1 else []}
    problem = Problem(PAIRS, PAIR_STREAMS, samplers, [("Thing", a) for a in range(things)], ("Open",))
    solution = solve(problem, algorithm="incremental", timeout=60.0)
    assert solution.status == "solved"
    return solution.report.counts["iterations"]


def test_many_stream_instances_come_up_in_few_rounds():
    """States that streams make of states came to many thousands, five hundred a round, which looked at them all."""
    assert rounds_for_pairs(100) <= rounds_for_pairs(50) + 10
