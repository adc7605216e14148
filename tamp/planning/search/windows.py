"""Windows of a plan, each searched for anew: what takes many steps is too much for one search below its cost.

From the state before a window to what the rest of the plan needs there may be a cheaper way, which is a small search
(Siddiqui and Haslum, "Plan Quality Optimisation via Block Decomposition", IJCAI 2013; windows of consecutive actions).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

from tamp.planning.grounding.ground_task import GroundTask, TaskOperator
from tamp.planning.model.normal_form import ActionSchema
from tamp.planning.search.best_first import SearchResult, Space
from tamp.planning.search.elimination import eliminate, reaches, relevant_axioms

Plan = tuple[TaskOperator, ...]

WINDOW, STRIDE = 12, 4
"""Actions of a window, and how far one begins after the last. Windows grow by half where none was worth while."""

WINDOWS = 24
"""How many are searched at most."""

LEAST_GAIN = 100
"""A window is worth while where one part of so many of what it costs is saved."""


def improve_windows(task: GroundTask, plan: Plan, search: Callable[[GroundTask, int], SearchResult]) -> SearchResult:
    """The plan, or a cheaper one, with the number of states that were looked at.

    Args:
        task: what the plan is for.
        plan: one that reaches the task's goal.
        search: looks for a plan for a task below a cost.
    """
    count = start = in_vain = searched = 0
    length = WINDOW
    states = _states(task, plan)
    known = set[tuple[int, ...]]()
    while searched < WINDOWS:
        end = min(start + length, len(plan))
        part, dear = _between(task, plan, states, start, end), cost(plan[start:end])
        key = (states[start], -1, *part.goal_positive, -1, *part.goal_negative)
        in_vain += 1
        if dear and key not in known:
            known.add(key)
            found = search(part, dear - dear // LEAST_GAIN)
            searched, count = searched + 1, count + found.states
            other = plan if found.plan is None else (*plan[:start], *found.plan, *plan[end:])
            if cost(other) < cost(plan) and reaches(task, other):
                plan, in_vain = eliminate(task, other), 0
                states = _states(task, plan)
        start = start + STRIDE if max(end, start + STRIDE) < len(plan) else 0  # it may be shorter now, or longer
        if in_vain * STRIDE >= len(plan):
            if length >= len(plan):
                break
            length, start, in_vain = length + length // 2, 0, 0
    return SearchResult(plan, states=count)


def seen_as(task: GroundTask, steps: Iterable[tuple[ActionSchema, dict[str, int]]]) -> Plan | None:
    """A plan of actions as a task has it, with its moves where they are operators of no action; None where it has not.

    Args:
        task: what is searched.
        steps: the actions and their bindings, of which those that the task leaves out are passed over.
    """
    own: dict[tuple[str, tuple[tuple[str, int], ...]], int] = {}
    for number, op in enumerate(task.operators):
        if op.source is not None:
            own.setdefault((op.source.schema.name, tuple(sorted(op.source.binding.items()))), number)
    moves = [number for number, op in enumerate(task.operators) if op.source is None]
    space, plan = Space(task), list[TaskOperator]()
    state = space.close(sum(1 << atom for atom in task.initial))

    def go_on(wanted: Callable[[int], bool]) -> bool:
        nonlocal state
        if wanted(state):
            return True
        for move in (m for m in moves if space.applicable(m, state)):
            after = space.close(space.apply(move, state))
            if wanted(after):
                plan.append(task.operators[move])
                state = after
                return True
        return False

    for schema, binding in steps:
        known = own.get((schema.name, tuple(sorted(binding.items()))))
        if known is None:
            continue
        if not go_on(partial(space.applicable, known)):
            return None
        plan.append(task.operators[known])
        state = space.close(space.apply(known, state))
    return tuple(plan) if go_on(space.is_goal) else None


def cost(plan: Plan) -> int:
    """What a plan costs."""
    return sum(step.cost for step in plan)


def _states(task: GroundTask, plan: Plan) -> list[int]:
    """The states before each action of a plan and after the last, as far as conditions of the plan speak of them."""
    space = Space(replace(task, operators=plan, axioms=tuple(relevant_axioms(task, plan))))
    states = [space.close(sum(1 << atom for atom in task.initial))]
    for step in range(len(plan)):
        states.append(space.close(space.apply(step, states[-1])))
    return states


def _between(task: GroundTask, plan: Plan, states: list[int], start: int, end: int) -> GroundTask:
    """From the state before a window to what the actions after it, and the goal, need.

    What their effects are conditional on is left open: whoever puts the parts together must look whether they fit.
    """
    positive, negative = set(task.goal_positive), set(task.goal_negative)
    for operator in reversed(plan[end:]):
        added = {effect.atom for effect in operator.effects if effect.adds and not effect.positive + effect.negative}
        deleted = {effect.atom for effect in operator.effects if not effect.adds}
        positive = (positive - added) | set(operator.positive)
        negative = (negative - (deleted - added)) | set(operator.negative)
    derived = {axiom.head for axiom in task.axioms}
    initial = (atom for atom in range(len(task.atoms)) if states[start] >> atom & 1 and atom not in derived)
    return replace(
        task,
        initial=frozenset(initial),
        goal_positive=tuple(sorted(positive)),
        goal_negative=tuple(sorted(negative)),
    )
