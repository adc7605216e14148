"""Samplers as users write them: what they may do, and what is refused with which sentence."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.errors import DomainError, SamplerError
from tamp.planning import Certified, Problem, StreamInfo, solve
from tamp.planning.context import generator_for
from tests.planning.test_problems import ALGORITHMS

DOMAIN = """
(define (domain shelf) (:requirements :strips)
  (:predicates (thing ?o) (spot ?p) (good ?p) (fits ?o ?p) (at ?o ?p) (loose ?o))
  (:action put :parameters (?o ?p) :precondition (and (thing ?o) (fits ?o ?p) (good ?p) (loose ?o))
    :effect (and (at ?o ?p) (not (loose ?o)))))
"""
STREAMS = """
(define (stream shelf)
  (:stream spots :inputs (?o) :domain (thing ?o) :outputs (?p) :certified (and (spot ?p) (fits ?o ?p)))
  (:stream is-good :inputs (?p) :domain (spot ?p) :certified (good ?p)))
"""


def shelf(spots, is_good=lambda context, p: p >= 3, info=None):
    return Problem(
        domain=DOMAIN,
        streams=STREAMS,
        samplers={"spots": spots, "is-good": is_good},
        init=[("thing", "cup"), ("loose", "cup")],
        goal=("not", ("loose", "cup")),
        info=info or {},
    )


def count_up(context, obj):
    yield from range(10)


def rarely(context, obj):
    for i in range(1000):
        yield i if i % 7 == 3 else None


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "incremental"])
@pytest.mark.parametrize("spots", [count_up, rarely, lambda context, obj: [1, 2, 3]])
def test_generators_are_asked_until_a_value_passes(spots, algorithm):
    solution = solve(shelf(spots), algorithm=algorithm, timeout=20.0)
    assert [action.args[0] for action in solution.plan] == ["cup"]
    assert solution.plan[0].args[1] >= 3


def test_an_exhausted_generator_proves_infeasibility():
    assert solve(shelf(lambda context, obj: iter([0, 1, 2])), timeout=20.0).status == "infeasible"


def test_generators_that_never_yield_run_into_the_timeout():
    def never(context, obj):
        while True:
            yield None

    assert solve(shelf(never), timeout=0.5).status == "timeout"


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "incremental"])
def test_a_sampler_may_pause_where_no_plan_waits_for_it(algorithm):
    paused = []

    def slow(context, obj):
        for _ in range(40):
            if context.brief:
                paused.append(obj)
                context.pause()
                yield None
        yield 7

    solution = solve(shelf(slow), algorithm=algorithm, timeout=20.0)
    assert solution.plan[0].args == ("cup", 7)
    assert bool(paused) == (algorithm == "incremental")  # the others have a plan first, which waits


def test_pauses_are_no_failures():
    def resting(context, obj):
        if context.brief:
            context.fail("not told yet")
            context.pause()
            yield None

    (spots, _) = solve(shelf(resting), algorithm="incremental", timeout=20.0).report.streams
    assert (spots.calls, spots.failures) == (1, (("not told yet", 1),))


def test_wild_facts_are_certified():
    def sure(context, obj):
        yield Certified(7, facts=(("good", 7),))

    solution = solve(shelf(sure, is_good=lambda context, p: False), timeout=20.0)
    assert solution.plan[0].args == ("cup", 7)


def test_arrays_are_values():
    def arrays(context, obj):
        yield np.zeros(3)

    solution = solve(shelf(arrays, lambda context, p: bool(p.sum() == 0)), timeout=20.0)
    assert isinstance(solution.plan[0].args[1], np.ndarray)


def test_reasons_are_counted():
    def choosy(context, obj):
        for i in range(6):
            if i < 5:
                context.fail("too low")
                yield None
            else:
                yield i

    report = solve(shelf(choosy), timeout=20.0).report
    stream = next(s for s in report.streams if s.name == "spots")
    assert stream.failures == (("too low", 5),)
    assert (stream.calls, stream.successes) == (6, 1)
    assert "too low" in str(report)


def test_an_exception_tells_stream_and_inputs():
    def broken(context, obj):
        yield 1 / 0

    with pytest.raises(SamplerError, match=r"stream 'spots' raised .* for \(cup\): .*test_samplers.py:\d+") as caught:
        solve(shelf(broken), timeout=20.0)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


def test_an_exception_of_a_test_that_is_a_generator_tells_them_as_well():
    """It came through as it was: the generator runs only once it is asked for an answer."""

    def broken(context, p):
        yield 1 / 0

    with pytest.raises(SamplerError, match=r"stream '.*' raised .* for .*test_samplers.py:\d+"):
        solve(shelf(lambda context, obj: iter([1]), broken), timeout=20.0)


def test_a_test_that_is_a_generator_is_asked_for_one_answer():
    asked = []

    def endless(context, p):
        while True:
            asked.append(p)
            yield ()

    assert solve(shelf(lambda context, obj: iter([1]), endless), timeout=20.0).solved
    assert len(asked) == 1


def test_samplers_that_do_not_fit_are_refused():
    with pytest.raises(SamplerError, match=r"stream 'spots': expected a function of \(context, o\)"):
        shelf(lambda context: iter(()))
    with pytest.raises(SamplerError, match="expected a generator function"):
        solve(shelf(lambda context, obj: 3), timeout=20.0)
    with pytest.raises(SamplerError, match="expected True or False"):
        solve(shelf(count_up, is_good=lambda context, p: "yes"), timeout=20.0)
    with pytest.raises(SamplerError, match="has no sampler"):
        Problem(domain=DOMAIN, streams=STREAMS, samplers={"spots": count_up}, init=[], goal=None)
    with pytest.raises(SamplerError, match="did you mean 'spots'"):
        Problem(domain=DOMAIN, streams=STREAMS, samplers={"spot": count_up, "spots": count_up}, init=[], goal=None)


def test_a_class_in_place_of_its_instance_is_told_from_a_function():
    class Spots:
        def __init__(self, count=20):
            self.count = count

        def __call__(self, context, obj):
            yield from range(self.count)

    with pytest.raises(
        SamplerError, match=r"found the class .*Spots, .* by Spots\(count=20\); give an instance: too many"
    ):
        shelf(Spots)
    assert solve(shelf(Spots()), timeout=20.0).solved


@pytest.mark.parametrize(
    ("told", "valid"),
    [
        ((np.zeros(3),), r"takes a reason in words, found array\(\[0., 0., 0.\]\)"),
        ((ValueError("low"),), "takes a reason in words, found ValueError"),
        (("low", ("On", "cup")), r"takes a list of facts such as .* found \('On', 'cup'\)"),
        (("low", 5), "takes a list of facts such as .* found 5"),
    ],
)
def test_a_reason_that_is_none_is_the_samplers_mistake(told, valid):
    def tells(context, obj):
        context.fail(*told)
        yield None

    with pytest.raises(
        SamplerError, match=rf"stream 'spots' raised TypeError: context.fail {valid}.*test_samplers.py:"
    ):
        solve(shelf(tells), timeout=20.0)


def test_bad_information_is_refused():
    with pytest.raises(DomainError, match="p_success"):
        StreamInfo(p_success=-0.1)
    with pytest.raises(DomainError, match="unknown algorithm"):
        solve(shelf(count_up), algorithm="fastest")
    with pytest.raises(DomainError, match="unknown search"):
        solve(shelf(count_up), search="fastest")


def test_eager_streams_are_called_before_any_search():
    calls = []

    def spots(context, obj):
        calls.append(obj)
        yield 5

    solve(shelf(spots, info={"spots": StreamInfo(eager=True)}), timeout=20.0)
    assert calls == ["cup"]


def test_random_numbers_depend_on_seed_stream_and_inputs_alone():
    first = generator_for(1, "spots", ["a"]).random(3)
    assert (first == generator_for(1, "spots", ["a"]).random(3)).all()
    others = [generator_for(*key).random(3) for key in ((2, "spots", ["a"]), (1, "spot", ["a"]), (1, "spots", ["b"]))]
    assert all((first != other).all() for other in others)


def test_a_test_is_asked_though_another_stream_certifies_the_same():
    asked = []

    def is_good(context, spot):
        asked.append(spot)
        return False

    problem = Problem(
        domain=DOMAIN,
        streams=STREAMS.replace(
            "(:stream is-good", "(:stream best :certified (good ?p) :outputs (?p)) (:stream is-good"
        ),
        samplers={"spots": lambda context, obj: [1], "is-good": is_good, "best": lambda context: [1]},
        init=[("thing", "cup"), ("loose", "cup"), ("fits", "cup", 0), ("spot", 0)],
        goal=("not", ("loose", "cup")),
    )
    assert solve(problem, timeout=20.0).plan[0].args == ("cup", 1)
    assert 0 in asked


def test_facts_beyond_the_promise_may_come_late():
    def generous(context, obj):
        yield Certified(0)
        yield from [None] * 20
        yield Certified(1, facts=[("good", 1)])

    solution = solve(shelf(generous, is_good=lambda context, p: False), timeout=20.0)
    assert solution.plan[0].args == ("cup", 1)


@pytest.mark.parametrize("algorithm", ["adaptive", "focused", "incremental"])
def test_a_chain_without_end_does_not_keep_sampling_out(algorithm):
    domain = """(define (domain steps) (:predicates (num ?n) (next ?a ?b) (at ?n))
      (:action go :parameters (?a ?b) :precondition (and (at ?a) (next ?a ?b)) :effect (and (at ?b) (not (at ?a)))))"""
    streams = """(define (stream steps)
      (:stream successor :inputs (?a) :domain (num ?a) :outputs (?b) :certified (and (num ?b) (next ?a ?b))))"""
    problem = Problem(
        domain=domain,
        streams=streams,
        samplers={"successor": lambda context, n: [n + 1]},
        init=[("num", 0), ("at", 0)],
        goal=("at", 3),
    )
    assert len(solve(problem, algorithm=algorithm, timeout=20.0).plan) == 3


CAVES = """
(define (domain caves)
  (:predicates (Cave ?c) (Way ?c1 ?c2) (Deep ?c) (Alike ?c1 ?c2) (At ?c) (Odd ?c))
  (:action go :parameters (?c1 ?c2) :precondition (and (Way ?c1 ?c2) (At ?c1)) :effect (and (At ?c2) (not (At ?c1))))
  (:derived (Odd ?c1) (exists (?c2) (and (Cave ?c1) (Cave ?c2) (not (Alike ?c1 ?c2)) (At ?c2)))))
"""

CAVE_STREAMS = """
(define (stream caves)
  (:stream look :inputs (?c) :domain (Cave ?c))
  (:stream test-alike :inputs (?c1 ?c2) :domain (and (Cave ?c1) (Cave ?c2)) :certified (Alike ?c1 ?c2)))
"""


@pytest.mark.filterwarnings("ignore:.*certifies nothing")
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_tests_that_nothing_needs_are_not_asked_for_what_other_streams_bring(algorithm):
    """That one stream certifies more than it promises says nothing of a test that has answered and did not."""
    asked, looked = [], []

    def look(context, cave):
        looked.append(cave)
        yield Certified((), (("Cave", cave + 1), ("Way", cave, cave + 1)))

    def alike(context, cave1, cave2):
        asked.append((cave1, cave2))
        return True

    problem = Problem(
        domain=CAVES,
        streams=CAVE_STREAMS,
        samplers={"look": look, "test-alike": alike},
        init=[("Cave", 0), ("At", 0)],
        goal=("At", 12),
    )
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.status == "solved", str(solution.report)
    assert len(solution.plan) == 12 and len(asked) <= 12
    assert len(looked) < 50  # each cave brings another one, without end


def test_an_exception_tells_which_stream_gave_what_it_was_about():
    def choosy(context, p):
        return p.good

    with pytest.raises(SamplerError, match=r"stream 'is-good' raised AttributeError: .* for \(3 from spots\)"):
        solve(shelf(lambda context, obj: [3], is_good=choosy), timeout=20.0)
