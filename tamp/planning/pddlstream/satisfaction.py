"""Constraint satisfaction with streams: values for variables such that facts hold of them, as a problem of one action.

terms = [("Pose", "a", "?p"), ("CFree", "?p", "?q"), Minimize(("Distance", "?p", "?q"))]
bindings, cost, certified = constraint_satisfaction(streams, stream_map, init, terms)
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from tamp.errors import DomainError
from tamp.planning.keywords import problem_of
from tamp.planning.solve import solve

MINIMIZE = "minimize"

CONNECTIVES = ("and", "or", "not", "imply", "=")

VARIABLE = re.compile(r"\?[^\s();?]+")

ACTION, DONE = "assign-values", "values-assigned"
"""The action of the problem and the predicate of its goal."""


class Assignment(NamedTuple):
    """Variable -> value, None where there are none; what they cost; facts that hold of them and of all else."""

    bindings: dict[str, Any] | None
    cost: float
    certified: tuple[tuple[Any, ...], ...]


def Minimize(function: Any) -> tuple[str, Any]:
    """A term that says what shall be small; several are summed."""
    return (MINIMIZE, function)


class SatisfactionProblem(NamedTuple):
    """Streams, facts that hold, and terms for which values are wanted."""

    stream_pddl: Any
    stream_map: Any
    init: Iterable[Any]
    terms: Iterable[Any]


def constraint_satisfaction(
    stream_pddl: Any, stream_map: Any = None, init: Iterable[Any] = (), terms: Iterable[Any] = (), **options: Any
) -> Assignment:
    """Values such that all terms hold.

    Args:
        stream_pddl: the streams' text, or a list of such texts; or a `SatisfactionProblem`, in place of all four.
        stream_map: their samplers, wrapped.
        init: facts that hold.
        terms: facts with variables such as "?p" and values, formulas of them with `And`, `Or`, `Not`, `Imply` and
            `Equal`, and `Minimize(("Distance", "?p", "?q"))`.
        options: as for `solve`; `costs=False` for any values.

    Raises:
        DomainError: where a term cannot be read.
    """
    if isinstance(stream_pddl, tuple):
        stream_pddl, stream_map, init, terms = stream_pddl
    if options.pop("costs", True) is False:
        options["unit_costs"] = True
    reader = _Reader()
    wanted: list[str] = []
    costs: list[str] = []
    for term in terms:
        if _head(term) == MINIMIZE:
            costs.append(reader.function(term))
        else:
            wanted.append(reader.text(term))
    if both := reader.predicates.keys() & reader.functions.keys():
        raise DomainError(f"{sorted(both)[0]!r} is a predicate in one term and minimised in another")
    variables = " ".join(reader.variables)
    predicates = " ".join(reader.declared(reader.predicates))
    effects = " ".join(f"(increase (total-cost) {cost})" for cost in costs) or "(increase (total-cost) 0)"
    domain = f"""
    (define (domain satisfaction)
      (:constants {" ".join(reader.constants)})
      (:predicates ({DONE}) {predicates})
      (:functions (total-cost) {" ".join(reader.declared(reader.functions))})
      (:action {ACTION}
        :parameters ({variables})
        :precondition (and {" ".join(wanted)})
        :effect (and ({DONE}) {effects})))
    """
    problem = problem_of((domain, reader.constants, stream_pddl, stream_map, list(init), (DONE,)))
    solution = solve(problem, **options)
    if solution.plan is None:
        return Assignment(None, solution.cost, solution.certified)
    bindings = dict(zip(reader.variables, solution.plan[0].args, strict=True))
    return Assignment(bindings, solution.cost, solution.certified)


def solve_pddlstream_satisfaction(
    stream_pddl: Any,
    stream_map: Any = None,
    init: Iterable[Any] = (),
    constraints: Iterable[Any] = (),
    incremental: bool = False,
    **options: Any,
) -> Assignment:
    """As `constraint_satisfaction`, by algorithm "incremental" or by the usual one.

    Raises:
        DomainError: where a constraint cannot be read.
    """
    chosen = {"algorithm": "incremental"} if incremental else {}
    return constraint_satisfaction(stream_pddl, stream_map, init, constraints, **{**chosen, **options})


def dump_assignment(solution: Assignment) -> None:
    """Print the values, and what they cost."""
    bindings, cost, _ = solution
    print(f"Solved: {bindings is not None}\nCost: {cost:.3f}")
    for variable, value in (bindings or {}).items():
        print(f"{variable} = {value}")


def _head(term: Any) -> str:
    if not isinstance(term, tuple | list) or not term or not isinstance(term[0], str):
        raise DomainError(f"expected a term such as ('Pose', 'a', '?p'), found {term!r}")
    return term[0].lower()


class _Reader:
    """Writes terms as PDDL, and keeps what they name."""

    def __init__(self) -> None:
        self.variables: dict[str, None] = {}
        self.constants: dict[str, Any] = {}
        self.predicates: dict[str, int] = {}
        self.functions: dict[str, int] = {}

    def text(self, term: Any) -> str:
        head = _head(term)
        if head in CONNECTIVES:
            parts = map(self._argument, term[1:]) if head == "=" else map(self.text, term[1:])
        else:
            self.predicates[head] = len(term) - 1
            parts = map(self._argument, term[1:])
        return f"({' '.join([head, *parts])})"

    def function(self, term: Any) -> str:
        """What is minimised: a function of variables and values, no formula."""
        head = _head(term[1]) if len(term) == 2 else MINIMIZE
        if head in (MINIMIZE, *CONNECTIVES):
            raise DomainError(f"expected Minimize(('Distance', '?p', '?q')), a function and arguments, found {term!r}")
        self.functions[head] = len(term[1]) - 1
        return f"({' '.join([head, *map(self._argument, term[1][1:])])})"

    def _argument(self, value: Any) -> str:
        if isinstance(value, str) and value.startswith("?"):
            if not VARIABLE.fullmatch(value):
                raise DomainError(f"expected a variable such as '?p', found {value!r}")
            self.variables[value.lower()] = None
            return value
        name = f"value-{len(self.constants)}"
        self.constants[name] = value
        return name

    @staticmethod
    def declared(table: Mapping[str, int]) -> Iterator[str]:
        for name, arity in table.items():
            yield f"({' '.join([name, *(f'?x{i}' for i in range(arity))])})"
