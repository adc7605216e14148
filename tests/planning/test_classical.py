"""Problem files in PDDL, and what else PDDLStream's scripts import."""

from types import SimpleNamespace

import pytest

from tamp.planning import Problem, solve
from tamp.planning.pddlstream import (
    FunctionInfo,
    accelerate_list_gen_fn,
    add_opt_function,
    classical_problem,
    from_gen,
    from_gen_fn,
    from_stream_map,
    from_test,
    inf_generator,
    solve_from_pddl,
)
from tests.planning.test_problems import check

DOMAIN = """
(define (domain errands)
  (:requirements :typing :equality :action-costs)
  (:types place thing)
  (:predicates (at ?p - place) (has ?t - thing) (sells ?p - place ?t - thing))
  (:functions (total-cost) (far ?p - place ?q - place))
  (:action go :parameters (?p - place ?q - place) :precondition (and (at ?p) (not (= ?p ?q)))
    :effect (and (at ?q) (not (at ?p)) (increase (total-cost) (far ?p ?q))))
  (:action buy :parameters (?p - place ?t - thing) :precondition (and (at ?p) (sells ?p ?t))
    :effect (and (has ?t) (increase (total-cost) 1))))
"""

PROBLEM = """
(define (problem shopping)
  (:domain errands)
  (:objects Home Shop - place Milk Bread - thing)
  (:init (at Home) (sells Shop Milk) (sells Shop Bread) (= (far Home Shop) 2.5) (= (far Shop Home) 3))
  (:goal (and (forall (?t - thing) (has ?t)) (at Home)))
  (:metric minimize (total-cost)))
"""


def test_a_problem_file():
    plan, cost = solve_from_pddl(DOMAIN, PROBLEM, success_cost=0.0, timeout=10.0)
    assert cost == 7.5
    assert sorted(name for name, _ in plan) == ["buy", "buy", "go", "go"]
    problem = classical_problem(DOMAIN, PROBLEM)
    check(problem, solve(problem, timeout=10.0))


def test_a_problem_that_has_no_plan():
    unreachable = PROBLEM.replace("(sells Shop Milk)", "")
    assert solve_from_pddl(DOMAIN, unreachable, timeout=10.0)[0] is None


CONTROL = """
(define (domain control)
  (:predicates (Control ?x) (Goal))
  (:action execute :parameters (?x) :precondition (Control ?x)
    :effect (and (Goal) (increase (total-cost) 2) (increase (total-cost) (Cost ?x)))))
"""

CONTROL_STREAMS = """
(define (stream control)
  (:stream sample-control :outputs (?x) :certified (Control ?x))
  (:function (Cost ?x) (Control ?x)))
"""


def test_functions_of_costs_with_a_lower_bound():
    stream_map = {"sample-control": from_gen((i,) for i in inf_generator())}
    with pytest.warns(UserWarning, match="opt_gen_fn"):
        FunctionInfo(opt_fn=lambda x: 1.0)
    stream_map, info = add_opt_function("Cost", lambda x: 1.0 / (x + 1), stream_map, {}, constant=1.0)
    problem = Problem(CONTROL, CONTROL_STREAMS, from_stream_map(stream_map), [], ("Goal",), info=info)
    plan, cost, certificate = solve(problem, timeout=0.5, success_cost=3.1)
    assert plan is not None and 3.0 <= cost <= 4.0
    assert certificate.preimage_facts == list(certificate)
    assert ("control", plan[0].args[0]) in certificate.all_facts


def test_what_another_class_says_of_a_stream():
    stream_map = {"sample-control": from_gen((i,) for i in inf_generator()), "Cost": lambda x: 1.0}
    info = SimpleNamespace(eager=True, p_success=None, overhead=2.0, defer_fn=None, opt_gen_fn=object())
    problem = (CONTROL, {}, CONTROL_STREAMS, stream_map, [], ("Goal",))
    assert solve(problem, stream_info={"sample-control": info}, max_time=10).solved


def test_lists_that_are_put_together():
    generate = accelerate_list_gen_fn(lambda n: ([(i,)] * (i % 2) for i in range(n)), num_elements=2, max_attempts=5)
    assert list(generate(6)) == [[(1,), (3,)], [(5,)]]


def test_what_is_wrapped_is_accelerated_as_well():
    """It was called with the first input as its context."""
    wrapped = from_gen_fn(lambda n: ((i,) if i % 3 == 2 else None for i in range(n)))
    hastened = from_stream_map({"draw": accelerate_list_gen_fn(wrapped, max_attempts=2)})["draw"]
    assert list(hastened(SimpleNamespace(sees_fluents=False), 7)) == [None, 2, None, 5, None]
    told = from_stream_map({"test": accelerate_list_gen_fn(from_test(lambda n: n > 3), max_attempts=2)})["test"]
    assert told(SimpleNamespace(sees_fluents=False), 5) is True


UNTYPED = """
(define (domain paint)
  (:predicates (red ?x))
  (:action paint :parameters (?x) :effect (red ?x)))
"""


def test_objects_without_types_of_which_nothing_is_said():
    problem = "(define (problem all) (:domain paint) (:objects a b) (:init) (:goal (forall (?x) (red ?x))))"
    plan, _ = solve_from_pddl(UNTYPED, problem, timeout=10.0)
    assert sorted(args for _, args in plan) == [("a",), ("b",)]
