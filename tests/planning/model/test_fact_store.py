"""What is known: which objects the search knows of, whichever streams give them."""

import pytest

from benchmarks.pddlstream.belief import hidden
from tamp import clock
from tamp.planning import Problem, solve
from tamp.planning.algorithms.session import Session
from tamp.planning.options import Options
from tamp.planning.search.fast_downward import FastDownward
from tests.planning.test_problems import ALGORITHMS, check

ROWS = """
(define (domain rows)
  (:predicates (Number ?n) (After ?n ?m) (Before ?n ?m) (At ?n))
  (:action go :parameters (?n ?m) :precondition (and (After ?n ?m) (At ?n)) :effect (and (At ?m) (not (At ?n))))
  (:action back :parameters (?n ?m) :precondition (and (Before ?n ?m) (At ?n)) :effect (and (At ?m) (not (At ?n)))))
"""

ROWS_STREAMS = """
(define (stream rows)
  (:stream after :inputs (?n) :domain (Number ?n) :outputs (?m) :certified (and (Number ?m) (After ?n ?m)))
  (:stream before :inputs (?n) :domain (Number ?n) :outputs (?m) :certified (and (Number ?m) (Before ?n ?m))))
"""


def drawn(after, before):
    """A session in which each stream was called once for 0; neither result is shown to the search."""
    samplers = {"after": lambda context, n: iter(after), "before": lambda context, n: iter(before)}
    problem = Problem(ROWS, ROWS_STREAMS, samplers, [("Number", 0), ("At", 0)], ("At", 5))
    session = Session(problem, Options(), FastDownward(), eager=False, started=clock.now())
    session.begin()
    made = [session.knowledge.instance(session.schema.externals[n], (session.objects.intern(0),)) for n in samplers]
    for instance in made:
        session.sampling.draw(instance)
    return session, made


def test_what_the_problem_gives_stays_known_where_a_stream_gives_it_as_well():
    session, _ = drawn([0], [1])
    given = session.objects.intern(0)
    assert session.knowledge.is_shown(given) and session.knowledge.source(given) is None


def test_what_two_streams_give_is_known_where_either_is_shown():
    session, (after, before) = drawn([1], [1])
    found = session.objects.intern(1)
    assert not session.knowledge.is_shown(found)
    session.knowledge.activate(before, 1)
    assert session.knowledge.is_shown(found) and session.knowledge.source(found) is after


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_values_that_come_again_are_gone_on_from(algorithm):
    """To shift a thing to where it is gives what was given; nothing was drawn for it in the rounds after that."""
    solution = solve(hidden(), algorithm=algorithm, timeout=20.0)
    check(hidden(), solution)
    assert len(solution.plan) == 3 and solution.cost < 3.5
