"""Action elimination: a plan without actions that its goal does not need (Nakhost and Mueller, ICAPS 2010).

Heuristic searches, and those that take what is only assumed as free, leave such actions in their plans.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from tamp.planning.grounding.ground_task import GroundTask, TaskAxiom, TaskOperator
from tamp.planning.search.best_first import Space

EFFORT = 400_000
"""How many rules may be looked at; a longer plan stays as it is."""


def reaches(task: GroundTask, plan: tuple[TaskOperator, ...]) -> bool:
    """Whether every operator of a plan can be applied in its turn, and the goal holds in the end."""
    if not all(isinstance(operator, TaskOperator) for operator in plan):
        return False
    space = Space(replace(task, operators=tuple(plan), axioms=tuple(relevant_axioms(task, plan))))
    state = space.close(sum(1 << atom for atom in task.initial))
    for step in range(len(plan)):
        if not space.applicable(step, state):
            return False
        state = space.close(space.apply(step, state))
    return space.is_goal(state)


def eliminate(task: GroundTask, plan: tuple[TaskOperator, ...]) -> tuple[TaskOperator, ...]:
    """The plan without each action that can be left out together with those that then are not possible any more."""
    axioms = tuple(relevant_axioms(task, plan))
    if len(plan) ** 2 * (1 + len(axioms)) > EFFORT:
        return plan
    space = Space(replace(task, operators=plan, axioms=axioms))
    steps = list(range(len(plan)))
    state = space.close(sum(1 << atom for atom in task.initial))
    position = 0
    while position < len(steps):
        rest = _without(space, state, steps[position:])
        if rest is not None:
            steps[position:] = rest
        else:
            state = space.close(space.apply(steps[position], state))
            position += 1
    return tuple(plan[step] for step in steps)


def _without(space: Space, state: int, steps: list[int]) -> list[int] | None:
    """What is left of some steps without the first and those that rest on it; None where the goal needs it."""
    kept: list[int] = []
    for step in steps[1:]:
        if space.applicable(step, state):
            kept.append(step)
            state = space.close(space.apply(step, state))
    return kept if space.is_goal(state) else None


def relevant_axioms(task: GroundTask, plan: tuple[TaskOperator, ...]) -> Iterator[TaskAxiom]:
    """The axioms that conditions of a plan and its goal may depend on."""
    wanted = {*task.goal_positive, *task.goal_negative}
    for operator in plan:
        wanted.update(operator.positive, operator.negative)
        for effect in operator.effects:
            wanted.update(effect.positive, effect.negative)
    defining: dict[int, list[TaskAxiom]] = {}
    for axiom in task.axioms:
        defining.setdefault(axiom.head, []).append(axiom)
    queue = [atom for atom in wanted if atom in defining]
    for atom in queue:  # grows while it is walked through
        for axiom in defining[atom]:
            more = [a for a in (*axiom.positive, *axiom.negative) if a in defining and a not in wanted]
            wanted.update(more)
            queue += more
    return (axiom for axiom in task.axioms if axiom.head in wanted)
