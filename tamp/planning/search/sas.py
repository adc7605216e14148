"""A ground task in SAS+, the input language of Fast Downward's search (its documentation, "output.sas", version 3)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from tamp.planning.grounding.ground_task import GroundTask, TaskAxiom, TaskEffect, TaskOperator, axiom_layers


@dataclass(frozen=True)
class _Variables:
    """Which variable and value say that an atom is true, and which that it is false.

    An atom shares a variable with the atoms it excludes. Where it is also wanted false, and falsity is not a single
    value of that variable, it gets a second one of its own with two values: a negated value of a variable with many
    values would need a disjunction, which Fast Downward compiles at a price.
    """

    sizes: tuple[int, ...]
    names: tuple[tuple[str, ...], ...]
    true: dict[int, tuple[int, int]]
    false: dict[int, tuple[int, int]]
    own: dict[int, int]
    layers: tuple[int, ...]


def write_sas(task: GroundTask) -> str | None:
    """The task as text, operators named by their numbers; None where its goal wants atoms that exclude each other."""
    variables = _variables(task)
    lines = ["begin_version", "3", "end_version", "begin_metric", "1", "end_metric", str(len(variables.sizes))]
    for i, size in enumerate(variables.sizes):
        lines += ["begin_variable", f"var{i}", str(variables.layers[i]), str(size), *variables.names[i], "end_variable"]
    lines.append("0")
    lines += ["begin_state", *map(str, _initial(task, variables)), "end_state"]
    goal = _condition(task.goal_positive, task.goal_negative, variables)
    if goal is None:
        return None
    lines += ["begin_goal", str(len(goal)), *(f"{var} {value}" for var, value in goal.items()), "end_goal"]
    operators = [text for i, op in enumerate(task.operators) if (text := _operator(i, op, variables))]
    lines += [str(len(operators)), *operators]
    axioms = [text for axiom in task.axioms if (text := _axiom(axiom, variables))]
    lines += [str(len(axioms)), *axioms, ""]
    return "\n".join(lines)


def _variables(task: GroundTask) -> _Variables:
    derived = {axiom.head for axiom in task.axioms}
    wanted_false = _wanted_false(task)
    group_of = {atom: group for group in task.groups for atom in group}
    sizes: list[int] = []
    names: list[tuple[str, ...]] = []
    layers: list[int] = []
    true: dict[int, tuple[int, int]] = {}
    false: dict[int, tuple[int, int]] = {}
    own: dict[int, int] = {}
    layer = axiom_layers(task.axioms)

    def variable(values: tuple[str, ...], at: int = -1) -> int:
        sizes.append(len(values))
        names.append(values)
        layers.append(at)
        return len(sizes) - 1

    for atom in range(len(task.atoms)):
        group = group_of.get(atom)
        if atom in true:
            continue
        if atom in derived:
            var = variable((f"Atom a({atom})", f"NegatedAtom a({atom})"), layer[atom])
            true[atom], false[atom] = (var, 0), (var, 1)
        elif group is None or len(group) == 1:
            var = variable((f"Atom a({atom})", f"NegatedAtom a({atom})"))
            true[atom], false[atom] = (var, 0), (var, 1)
        else:
            var = variable((*(f"Atom a({other})" for other in group), "<none of those>"))
            for value, other in enumerate(group):
                true[other] = (var, value)
    for atom in wanted_false:
        if atom not in false:
            own[atom] = variable((f"Atom b({atom})", f"NegatedAtom b({atom})"))
            false[atom] = (own[atom], 1)
    return _Variables(tuple(sizes), tuple(names), true, false, own, tuple(layers))


def _wanted_false(task: GroundTask) -> list[int]:
    found = dict.fromkeys(task.goal_negative)
    for op in task.operators:
        found.update(dict.fromkeys(op.negative))
        for effect in op.effects:
            found.update(dict.fromkeys(effect.negative))
    for axiom in task.axioms:
        found.update(dict.fromkeys(axiom.negative))
    return list(found)


def _initial(task: GroundTask, variables: _Variables) -> list[int]:
    values = [size - 1 for size in variables.sizes]  # "none of those", or false
    for atom in sorted(task.initial):
        var, value = variables.true[atom]
        values[var] = value
        if atom in variables.own:
            values[variables.own[atom]] = 0
    return values


def _condition(positive: Iterable[int], negative: Iterable[int], variables: _Variables) -> dict[int, int] | None:
    """Variable -> value; None where two values of one variable are wanted at once."""
    found: dict[int, int] = {}
    for var, value in (*(variables.true[a] for a in positive), *(variables.false[a] for a in negative)):
        if found.setdefault(var, value) != value:
            return None
    return found


def _operator(index: int, op: TaskOperator, variables: _Variables) -> str:
    condition = _condition(op.positive, op.negative, variables)
    if condition is None:
        return ""
    effects = _effects(op.effects, condition, variables)
    if not effects:
        return ""
    changed = {var for var, _, cond in effects if not cond}
    prevail = [f"{var} {value}" for var, value in condition.items() if var not in changed]
    lines = ["begin_operator", f"o{index}", str(len(prevail)), *prevail, str(len(effects))]
    for var, value, cond in effects:
        before = condition.get(var, -1) if var in changed else -1
        text = "".join(f" {v} {w}" for v, w in cond.items())
        lines.append(f"{len(cond)}{text} {var} {before} {value}")
    return "\n".join([*lines, str(op.cost), "end_operator"])


def _effects(
    effects: Iterable[TaskEffect], condition: dict[int, int], variables: _Variables
) -> list[tuple[int, int, dict[int, int]]]:
    """(variable, new value, condition) of an operator's effects.

    Deletions come first: Fast Downward applies effects in order, so that an addition wins, as PDDL has it.
    """
    added: list[tuple[int, int, dict[int, int]]] = []
    deleted: list[tuple[int, int, dict[int, int]]] = []
    for effect in effects:
        cond = _condition(effect.positive, effect.negative, variables)
        if cond is None or any(condition.get(v, w) != w for v, w in cond.items()):
            continue
        cond = {v: w for v, w in cond.items() if condition.get(v) != w}
        var, value = variables.true[effect.atom]
        own = variables.own.get(effect.atom)
        if effect.adds:
            added.append((var, value, cond))
            added += [(own, 0, cond)] if own is not None else []
        else:
            deleted += _deletion(var, value, cond, condition, variables)
            deleted += [(own, 1, cond)] if own is not None else []
    certain = {var for var, _, cond in added if not cond}
    return [effect for effect in deleted if effect[0] not in certain] + added


def _deletion(
    var: int, value: int, cond: dict[int, int], condition: dict[int, int], variables: _Variables
) -> list[tuple[int, int, dict[int, int]]]:
    """Set a variable to "none of those" where it has the value that is deleted."""
    if condition.get(var, value) != value or cond.get(var, value) != value:
        return []
    where = cond if condition.get(var) == value else {**cond, var: value}
    return [(var, variables.sizes[var] - 1, where)]


def _axiom(axiom: TaskAxiom, variables: _Variables) -> str:
    condition = _condition(axiom.positive, axiom.negative, variables)
    if condition is None:
        return ""
    var, value = variables.true[axiom.head]
    body = [f"{v} {w}" for v, w in condition.items()]
    return "\n".join(["begin_rule", str(len(body)), *body, f"{var} 1 {value}", "end_rule"])
