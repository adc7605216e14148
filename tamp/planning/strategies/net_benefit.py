"""Soft goals with utilities, compiled away into hard goals and costs.

Keyder and Geffner, "Soft goals can be compiled away", JAIR 36 (2009): each soft goal g with utility u becomes a hard
goal g', which `collect` reaches at no cost where g holds and `forgo` at cost u. Both are possible only after an action
`end`, after which no other action is, and in a fixed order. A plan of the compiled problem costs what its actions cost
and what the goals are worth that it forgoes, so that the cheapest one has the greatest net benefit.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import ClassVar

from tamp.errors import DomainError
from tamp.language import TRUE, Action, And, Atom, Domain, Effect, Not, Signature, atoms
from tamp.planning.options import Settings
from tamp.planning.problem import Problem, Solution
from tamp.planning.run import PlanningRun

MODE, ENDED, DONE = "net-benefit-acting", "net-benefit-ended", "net-benefit-decided-"
"""Predicates of the compiled problem: actions may be taken; soft goals may be decided; that one of them is."""

END, COLLECT, FORGO = "net-benefit-end", "net-benefit-collect-", "net-benefit-forgo-"
"""Its actions beside those of the domain."""


@dataclass(frozen=True)
class NetBenefit:
    """Reach the hard goals, and the soft ones that are worth their cost.

    Attributes:
        enough: a plan whose actions and forgone utilities cost at most this ends the run; otherwise better ones are
            looked for until none is left or the time limit is reached.
    """

    enough: float = 0.0
    name: ClassVar[str] = "net-benefit"
    supports_soft_goals: ClassVar[bool] = True

    def __call__(self, problem: Problem, settings: Settings) -> Solution:
        """Solve a problem; the cost of the solution is that of its actions and of the soft goals that it forgoes.

        Raises:
            DomainError: where there are no soft goals, or a setting does not suit them.
        """
        if not problem.soft_goals:
            raise DomainError("strategy 'net-benefit': the problem has no soft_goals")
        options = settings.options
        if options.unit_costs or options.constraints.alternatives or options.reuse is not None:
            raise DomainError(
                "strategy 'net-benefit': unit_costs would make goals worth nothing, and skeletons and earlier plans "
                "cannot be followed; use strategy 'all-at-once' with them"
            )
        options = replace(options, success_cost=min(options.success_cost, self.enough))
        found = PlanningRun(compiled(problem), replace(settings, options=options)).solve()
        return found if found.plan is None else _decompiled(found, problem)


def compiled(problem: Problem) -> Problem:
    """The problem without soft goals."""
    domain = problem.parsed_domain
    decided = [f"{DONE}{i}" for i in range(len(problem.soft_goals))]
    weighed = _deciding(problem)
    actions = {action.name: _while_acting(action, domain, weighed) for action in domain.actions.values()}
    ended = (Effect(Atom(MODE, ()), positive=False), Effect(Atom(ENDED, ())))
    actions[END] = Action(END, (), Atom(MODE, ()), ended, (0.0,))
    for i, (goal, utility) in enumerate(problem.soft_goal_formulas):
        before = [Atom(ENDED, ()), *(Atom(name, ()) for name in decided[:i][-1:])]
        turn = And((*before, Not(Atom(decided[i], ()))))
        done = (Effect(Atom(decided[i], ())),)
        actions[f"{COLLECT}{i}"] = Action(f"{COLLECT}{i}", (), And((turn, goal)), done, (0.0,))
        actions[f"{FORGO}{i}"] = Action(f"{FORGO}{i}", (), turn, done, (utility,))
    predicates = {name: Signature(name, ()) for name in (MODE, ENDED, *decided)}
    made = replace(domain, actions=actions, predicates={**domain.predicates, **predicates}, uses_costs=True)
    wanted = [("and",) if problem.goal is None else problem.goal, *((name,) for name in decided)]
    return replace(problem, domain=made, init=(*problem.init, (MODE,)), goal=("and", *wanted), soft_goals=())


def _deciding(problem: Problem) -> frozenset[str]:
    """The predicates on which it depends whether soft goals hold."""
    found = {atom.predicate for goal, _ in problem.soft_goal_formulas for atom in atoms(goal)}
    size = -1
    while size < (size := len(found)):
        for axiom in problem.parsed_domain.axioms:
            if axiom.predicate in found:
                found.update(atom.predicate for atom in atoms(axiom.condition))
    return frozenset(found)


def _while_acting(action: Action, domain: Domain, weighed: Collection[str]) -> Action:
    """An action as long as nothing is decided; where the domain has no costs, it costs 1 as it does there.

    One that changes nothing of what soft goals are about, such as a move of an empty hand, may come later as well.
    """
    cost = action.cost if domain.uses_costs else (1.0,)
    if all(effect.atom.predicate not in weighed for effect in action.effects):
        return replace(action, cost=cost)
    precondition = Atom(MODE, ()) if action.precondition == TRUE else And((Atom(MODE, ()), action.precondition))
    return replace(action, precondition=precondition, cost=cost)


def _decompiled(found: Solution, problem: Problem) -> Solution:
    """A solution without the actions that decide soft goals."""
    assert found.plan is not None
    own = (END, COLLECT, FORGO)
    plan = tuple(action for action in found.plan if not action.name.startswith(own))
    taken = [int(action.name.removeprefix(FORGO)) for action in found.plan if action.name.startswith(FORGO)]
    forgone = tuple(problem.soft_goals[i][0] for i in taken)
    certified = tuple(fact for fact in found.certified if fact[0] not in (MODE, ENDED))
    message = f"Forgone: {len(forgone)} of {len(problem.soft_goals)} soft goals. {found.report.message}".strip()
    report = replace(found.report, message=message)
    return replace(found, plan=plan, certified=certified, forgone=forgone, report=report)


__all__ = ["NetBenefit", "compiled"]
