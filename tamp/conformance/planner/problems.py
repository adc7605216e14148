"""Small problems whose answers are known, and their plans carried out from the definition of PDDL."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from tamp.conformance.checks import Fault
from tamp.language import And, Atom, Constant, Exists, Formula, Not, Term
from tamp.planning import Problem, Solution

WORKSHOP = """
(define (domain workshop)
  (:requirements :action-costs)
  (:predicates (key) (open) (burnt) (warm) (made ?x) (thing ?x) (dry ?x ?w) (finished ?x) (painted ?x ?w))
  (:functions (total-cost))
  (:derived (finished ?x) (and (made ?x) (not (burnt))))
  (:action burn :precondition (key)
    :effect (and (warm) (burnt) (not (key)) (increase (total-cost) 1)))
  (:action unlock :precondition (and (key) (not (burnt))) :effect (and (open) (increase (total-cost) 2)))
  (:action heat :precondition (open) :effect (and (warm) (increase (total-cost) 3)))
  (:action make :parameters (?x) :precondition (and (thing ?x) (warm) (open))
    :effect (and (made ?x) (increase (total-cost) 4)))
  (:action paint :parameters (?x ?w) :precondition (and (made ?x) (dry ?x ?w))
    :effect (and (painted ?x ?w) (not (warm)) (increase (total-cost) 5))))
"""
"""Burning the key is the cheapest way to be warm, and a dead end for all else."""

STREAMS = """
(define (stream workshop)
  (:stream mix :inputs (?x) :domain (thing ?x) :outputs (?w) :certified (dry ?x ?w)))
"""

THINGS = ("chair", "table")


def workshop(goal: Any, *, key: bool = True, soft: tuple[Any, ...] = ()) -> Problem:
    """A problem without streams."""
    init = [*(("thing", name) for name in THINGS), *([("key",)] if key else [])]
    return Problem(domain=WORKSHOP, init=init, goal=goal, soft_goals=soft)


def painting(*, drying: bool = True) -> Problem:
    """One with a stream that goes on for ever; nothing that it gives dries unless `drying`."""

    def mix(context: Any, thing: str) -> Iterator[Any]:
        while True:
            color = (thing, int(context.rng.integers(1000)))
            context.scene.append(color)
            yield color if drying else None

    init = [("key",), *(("thing", name) for name in THINGS)]
    goal = ("exists", ("?w",), ("painted", "chair", "?w"))
    return Problem(domain=WORKSHOP, streams=STREAMS, samplers={"mix": mix}, init=init, goal=goal, scene=[])


SOLVABLE: Mapping[str, Callable[[], Problem]] = {
    "two goals of which one can be reached so that the other cannot": lambda: workshop(("and", ("warm",), ("open",))),
    "a goal that is derived": lambda: workshop(("and", *(("finished", name) for name in THINGS))),
    "a goal that holds at the start": lambda: workshop(("key",)),
}

IMPOSSIBLE = "a goal that nothing leads to"


def impossible() -> Problem:
    """A problem that no plan solves."""
    return workshop(("finished", "chair"), key=False)


def carried_out(problem: Problem, solution: Solution) -> set[tuple[Any, ...]]:
    """The facts that hold after a solution's plan.

    Raises:
        Fault: where a step cannot be taken, the goal does not hold in the end, or the cost is another one.
    """
    domain, cost = problem.parsed_domain, 0.0
    state = set(_facts((*problem.init, *solution.certified)))
    if strange := [fact for fact in state if fact[0] == "dry" and fact[2] not in (problem.scene or ())]:
        raise Fault(f"it says that {strange[0]} is certified, and no stream gave {strange[0][2]}")
    for number, (name, args) in enumerate(solution.plan or ()):
        action = domain.actions.get(str(name).lower())
        if action is None or len(args) != len(action.parameters):
            raise Fault(f"step {number} of its plan is ({name} ...), which is no action of the domain")
        bound = {p.variable: value for p, value in zip(action.parameters, args, strict=True)}
        if not _holds(action.precondition, state, bound):
            raise Fault(f"step {number} of its plan, {name}, cannot be taken: its precondition does not hold then")
        for effect in sorted(action.effects, key=lambda effect: effect.positive):  # deletes first
            (state.add if effect.positive else state.discard)(_fact(effect.atom, bound))
        cost += sum(part for part in action.cost or () if isinstance(part, int | float))
    if not _holds(problem.goal_formula, state, {}):
        raise Fault(f"the goal {problem.goal} does not hold after its plan")
    if abs(solution.cost - cost) > 1e-6 and not problem.soft_goals:
        raise Fault(f"it says that its plan costs {solution.cost:g}; its actions cost {cost:g}")
    return state


def _facts(given: Any) -> Iterator[tuple[Any, ...]]:
    return ((str(fact[0]).lower(), *fact[1:]) for fact in given)


def _fact(atom: Atom, bound: dict[Any, Any]) -> tuple[Any, ...]:
    def value(term: Term) -> Any:
        return term.value if isinstance(term, Constant) else bound[term]

    return (atom.predicate, *map(value, atom.args))


def _holds(formula: Formula, state: set[tuple[Any, ...]], bound: dict[Any, Any]) -> bool:
    """Whether a formula of these problems holds, in which nothing is quantified but the goal of `painting`."""
    match formula:
        case Exists(_, Atom(predicate)):
            return any(fact[0] == predicate for fact in state)
        case Atom("finished", args):
            return _holds(And((Atom("made", args), Not(Atom("burnt", ())))), state, bound)
        case Atom():
            return _fact(formula, bound) in state
        case Not(inner):
            return not _holds(inner, state, bound)
        case And(parts):
            return all(_holds(part, state, bound) for part in parts)
    raise AssertionError(f"no problem here has {formula}")
