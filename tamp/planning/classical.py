"""Problem files in PDDL, for problems without streams: objects, initial state and goal, as nested tuples of names."""

from __future__ import annotations

from typing import Any

from tamp.language import PDDL
from tamp.language.read_domain import read_define
from tamp.language.read_formula import FormulaReader
from tamp.language.sexpr import Group, Node, Symbol, load, read
from tamp.planning.problem import Problem
from tamp.planning.solve import solve


def classical_problem(domain: PDDL, problem: PDDL) -> Problem:
    """A domain file and a problem file as a problem; its objects are their names, in lower case.

    Raises:
        DomainError: with file, line and column of what cannot be read.
    """
    source = load(problem, "problem")
    _, sections = read_define(source, read(source), "problem")
    reader = FormulaReader(source, {}, None, {}, open_world=True)
    init: list[Any] = []
    goal: Any = None
    for head, group in sections:
        if head.text == ":objects":
            for symbol, types in reader.typed_list(group, start=1):
                init += [((types[0].text if types else "object"), symbol.text)]
        elif head.text == ":init":
            init += map(_tuples, group.items[1:])
        elif head.text == ":goal" and len(group.items) == 2:
            goal = _tuples(group.items[1])
    return Problem(domain, None, {}, init, goal)


def solve_from_pddl(domain: PDDL, problem: PDDL, **options: Any) -> tuple[Any, float]:
    """The plan of a domain file and a problem file, None where there is none, and its cost; `options` as for `solve`.

    Raises:
        DomainError: with file, line and column of what cannot be read.
    """
    solution = solve(classical_problem(domain, problem), **options)
    return solution.plan, solution.cost


def _tuples(node: Node) -> Any:
    """An expression as nested tuples; numbers as such."""
    if isinstance(node, Group):
        return tuple(map(_tuples, node.items))
    assert isinstance(node, Symbol)
    try:
        return float(node.text)
    except ValueError:
        return node.text
