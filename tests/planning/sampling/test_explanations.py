"""Streams told the state that name no cause: what is found to be in the way, and what the search makes of it."""

from itertools import repeat

import numpy as np
import pytest

from benchmarks.pddlstream.shelf import carrying
from benchmarks.pddlstream_like import LINE
from tamp import clock
from tamp.planning import Problem, solve
from tamp.planning.algorithms.session import Session
from tamp.planning.options import Options
from tamp.planning.pddlstream import from_gen_fn, from_stream_map, from_test
from tamp.planning.search.fast_downward import FastDownward
from tests.planning.test_problems import ALGORITHMS, check
from tests.planning.test_told import LAMPS, LAMPS_STREAMS

LIT_STREAMS = """
(define (stream lamps)
  (:stream test-bright :inputs (?l) :domain (Lamp ?l) :fluents (On) :outputs (?t) :certified (Lit ?l ?t)))
"""


def why(says_no, names, streams=LAMPS_STREAMS, given=lambda bright: bright):
    """What is blamed for the answer of a stream that is told that all of some lamps are on."""
    asked = []

    def bright(context, lamp):
        on = {fact[1] for fact in context.fluents}
        asked.append(on)
        return given(not says_no(on))

    init = [*(("Lamp", name) for name in names), *(("On", name) for name in names)]
    problem = Problem(LAMPS, streams, {"test-bright": bright}, init, ("Read",))
    session = Session(problem, Options(), FastDownward(), eager=False, started=clock.now())
    session.begin()
    objects = session.objects
    told = tuple(("on", objects.intern(name)) for name in names)
    instance = session.knowledge.instance(session.schema.externals["test-bright"], (objects.intern(names[0]),), told)
    while not instance.exhausted and not instance.results and instance.calls < 8:
        session.sampling.draw(instance)
    asked.clear()
    found = {objects.value(fact[1]) for fact in session.evaluator.explanations.why(instance)}
    return found, len(asked)


NAMES = [f"lamp{i}" for i in range(32)]


@pytest.mark.parametrize("culprits", [{"lamp0"}, {"lamp31"}, {"lamp5", "lamp20"}])
def test_the_fewest_facts_are_found_with_few_questions(culprits):
    found, questions = why(lambda on: culprits <= on, NAMES)
    assert found == culprits
    assert questions <= 12 * len(culprits)


@pytest.mark.parametrize("misses", range(3))
def test_what_bars_a_stream_that_gives_values_is_found_as_well(misses):
    """All that it was told was blamed, so that any of it was put elsewhere in vain."""
    calls = [None] * misses
    found, _ = why(
        lambda on: "lamp5" in on, NAMES, LIT_STREAMS, lambda lit: iter([*calls, *(["light"] if lit else [])])
    )
    assert found == {"lamp5"}


def test_a_stream_that_has_not_ended_has_not_answered():
    found, questions = why(lambda on: "lamp5" in on, NAMES, LIT_STREAMS, lambda lit: repeat("light" if lit else None))
    assert (found, questions) == (set(), 0)


def test_that_it_says_no_in_any_case_is_no_reason():
    assert why(lambda on: True, NAMES) == (set(), 1)


def test_a_test_that_cannot_deal_with_fewer_facts_has_not_answered():
    def says_no(on):
        if "lamp1" not in on:
            raise KeyError("lamp1")
        return "lamp2" in on

    found, _ = why(says_no, NAMES[:4])
    assert found == {"lamp1", "lamp2"}


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("seed", range(2))
def test_what_bars_all_of_some_moves_is_put_elsewhere(seed, algorithm):
    """Each value that came up anew was tried past the tall block: timeouts with all but the algorithm "incremental"."""
    problem = carrying([-4.0, 0.0], {"A": "goal"}, LINE)
    solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=seed)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("seed", range(2))
def test_what_bars_all_of_some_paths_is_put_elsewhere(seed, algorithm):
    """As above, where a stream gives the paths: timeouts, or up to 16 actions where 8 will do."""
    problem = carrying([-4.0, 0.0], {"A": "goal"}, LINE, seed, paths=True)
    solution = solve(problem, algorithm=algorithm, timeout=20.0, seed=seed)
    assert solution.status == "solved" and len(solution.plan) == 8, str(solution.report)
    check(problem, solution)


DETOUR = """
(define (domain detour)
  (:predicates (Robot ?r) (Thing ?x) (Conf ?q) (Spot ?x ?q) (Free ?q1 ?q2) (At ?r ?q) (AtThing ?x ?q) (Held ?x) (Empty))
  (:action move
    :parameters (?r ?q1 ?q2) :precondition (and (Robot ?r) (Free ?q1 ?q2) (At ?r ?q1))
    :effect (and (At ?r ?q2) (not (At ?r ?q1))))
  (:action pick
    :parameters (?r ?x ?q)
    :precondition (and (Robot ?r) (Spot ?x ?q) (At ?r ?q) (AtThing ?x ?q) (Empty))
    :effect (and (Held ?x) (not (AtThing ?x ?q)) (not (Empty))))
  (:action place
    :parameters (?r ?x ?q) :precondition (and (Robot ?r) (Spot ?x ?q) (At ?r ?q) (Held ?x))
    :effect (and (AtThing ?x ?q) (Empty) (not (Held ?x)))))
"""

DETOUR_STREAMS = """
(define (stream detour)
  (:stream sample-spot :inputs (?x) :domain (Thing ?x) :outputs (?q) :certified (and (Conf ?q) (Spot ?x ?q)))
  (:stream test-free
    :inputs (?q1 ?q2) :domain (and (Conf ?q1) (Conf ?q2)) :fluents (AtThing Held) :certified (Free ?q1 ?q2)))
"""


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("hits", [lambda held: True, bool])
def test_what_nothing_can_move_is_gone_round(hits, algorithm):
    """A wall is in the way of all direct moves, or of those with something held; by a third point there is one."""
    rng = np.random.default_rng(0)
    home, start, wall, end, aside = (np.array(p, dtype=float) for p in ((-1, 0), (0, 0), (2, 0), (7, 0), (3, 5)))

    def free(a, b, fluents=()):
        held = any(fact[0].lower() == "held" for fact in fluents)
        walls = [fact[2] for fact in fluents if fact[0].lower() == "atthing" and fact[1] == "wall"]
        points = a + np.linspace(0.0, 1.0, 100)[:, None] * (b - a)
        return not (hits(held) and any(np.linalg.norm(points - wall, axis=1).min() < 0.3 for wall in walls))

    def sample_spot(thing):
        while True:
            yield (np.array([rng.uniform(6.0, 9.0), 0.0]),)

    init = [("Robot", "r"), ("At", "r", home), ("Empty",), ("Thing", "a"), ("AtThing", "a", start)]
    init += [*(("Conf", q) for q in (home, start, end, aside)), ("AtThing", "wall", wall)]
    init += [("Spot", "a", start), ("Spot", "a", end)]
    stream_map = {"sample-spot": from_gen_fn(sample_spot), "test-free": from_test(free)}
    problem = Problem(DETOUR, DETOUR_STREAMS, from_stream_map(stream_map), init, ("AtThing", "a", end))
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "solved", str(solution.report)
    check(problem, solution)
