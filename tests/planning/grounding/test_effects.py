"""Conditions of effects are read as they stand."""

import pytest

from tamp.planning import Problem, solve
from tests.planning.test_problems import ALGORITHMS, check

DOMAIN = """(define (domain d) (:requirements :adl) (:constants c) (:predicates (p ?x) (s) (t) (u))
  (:action act :parameters (?a ?b) :precondition (and (p ?a) (p ?b))
    :effect (and (when (= ?a ?b) (s)) (when (= ?a c) (t)) (when (not (= ?a ?b)) (u)))))"""


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(("goal", "args"), [("s", {("a", "a"), ("b", "b")}), ("u", {("a", "b"), ("b", "a")})])
def test_an_effect_where_two_parameters_are_the_same_object(goal, args, algorithm):
    """It was never seen, and problems that need it were called infeasible."""
    problem = Problem(DOMAIN, init=[("p", "a"), ("p", "b")], goal=(goal,), constants={"c": "c"})
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.plan is not None, solution.status
    assert {action.args for action in solution.plan} <= args
    check(problem, solution)


def test_an_effect_where_a_parameter_is_a_constant():
    init = [("p", "a"), ("p", "c")]
    solution = solve(Problem(DOMAIN, init=init, goal=("t",), constants={"c": "c"}), timeout=20.0)
    assert [action.args[0] for action in solution.plan] == ["c"]
    assert solve(Problem(DOMAIN, init=init[:1], goal=("t",), constants={"c": "c"})).status == "infeasible"


UNASKED = """(define (domain d) (:predicates (thing ?x) (item ?x) (ok ?x) (r ?x) (q))
  (:action wipe :parameters (?a) :precondition (r ?a) :effect (when (not (ok ?a)) (not (r ?a))))
  (:action need :parameters (?a) :precondition (and (r ?a) (item ?a)) :effect (q)))"""

TEST = "(define (stream s) (:stream test-ok :inputs (?x) :domain (and (thing ?x) (item ?x)) :certified (ok ?x)))"


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_an_effect_happens_where_no_test_that_would_prevent_it_can_be_asked(algorithm):
    """It was taken never to happen, and the problem called infeasible."""
    init = [("thing", "a"), ("thing", "b"), ("item", "b"), ("r", "a"), ("r", "b")]
    goal = ("and", ("not", ("r", "a")), ("q",))
    samplers = {"test-ok": lambda context, x: True}
    problem = Problem(UNASKED, TEST, samplers, init, goal)
    solution = solve(problem, algorithm=algorithm, timeout=20.0)
    assert solution.plan is not None, solution.status
    check(problem, solution)
    barred = Problem(UNASKED, TEST, samplers, init, ("and", ("not", ("r", "b")), ("q",)))
    assert solve(barred, algorithm=algorithm, timeout=20.0).status == "infeasible"
