"""Parameters of which an action says nothing: any object does, and one is taken."""

from dataclasses import replace

import pytest

from tamp.planning import Constraints, Problem, solve

DOMAIN = """
(define (domain drawing)
  (:predicates (pen ?p) (ink ?p ?i) (drawn ?p) (dry ?p))
  (:functions (price ?x))
  (:action draw
    :parameters (?p ?i ?with)
    :precondition (and (pen ?p) (ink ?p ?i))
    :effect (drawn ?p)))
"""
STREAMS = """
(define (stream drawing)
  (:stream fill :inputs (?p) :domain (pen ?p) :outputs (?i) :certified (ink ?p ?i)))
"""
PENS = [f"pen{i}" for i in range(60)]


def drawing(domain=DOMAIN, init=()):
    return Problem(
        domain=domain,
        streams=STREAMS,
        samplers={"fill": lambda context, pen: iter(range(3))},
        init=[*(("pen", pen) for pen in PENS), *init],
        goal=("and", *(("drawn", pen) for pen in PENS[:5])),
    )


@pytest.mark.parametrize("algorithm", ["adaptive", "incremental"])
def test_one_object_does_for_what_nothing_is_said_of(algorithm):
    """There was an operator for each object that is known or assumed, and more with each that was sampled."""
    solution = solve(drawing(), algorithm=algorithm, timeout=20.0)
    assert sorted(action.args[0] for action in solution.plan) == PENS[:5]
    assert all(action.args[2] in PENS for action in solution.plan)
    assert solution.report.counts["operators"] <= 300


def test_what_something_is_said_of_is_bound_as_before():
    wants = DOMAIN.replace("(and (pen ?p)", "(and (dry ?with) (pen ?p)")
    assert {a.args[2] for a in solve(drawing(wants, [("dry", "pen7")]), timeout=20.0).plan} == {"pen7"}
    wets = DOMAIN.replace(":effect (drawn ?p)", ":effect (and (drawn ?p) (not (dry ?with)))")
    problem = drawing(wets, [("dry", "pen7")])
    problem = replace(problem, goal=("and", problem.goal, ("not", ("dry", "pen7"))))
    assert "pen7" in {a.args[2] for a in solve(problem, timeout=20.0).plan}


def test_prices_and_inequalities_say_something():
    priced = DOMAIN.replace(":effect (drawn ?p)", ":effect (and (drawn ?p) (increase (total-cost) (price ?with)))")
    prices = [("=", ("price", x), 1 if x == "pen7" else 9) for x in (*PENS, 0, 1, 2)]
    assert {a.args[2] for a in solve(drawing(priced, prices), max_cost=5, timeout=20.0).plan} == {"pen7"}
    apart = DOMAIN.replace("(and (pen ?p)", "(and (not (= ?p ?with)) (pen ?p)")
    assert all(a.args[0] != a.args[2] for a in solve(drawing(apart), timeout=20.0).plan)


def test_who_asks_for_an_object_gets_it():
    wanted = Constraints(skeletons=[[("draw", "pen0", ..., "pen9"), ...]])
    assert "pen9" in {a.args[2] for a in solve(drawing(), constraints=wanted, timeout=20.0).plan}
    never = Constraints(forbidden=[("draw", ..., ..., "pen0")])
    assert "pen0" not in {a.args[2] for a in solve(drawing(), constraints=never, timeout=20.0).plan}
