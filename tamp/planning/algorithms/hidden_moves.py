"""Which moves the search leaves out of a problem, to be filled in between the actions that it finds."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

from tamp.planning.algorithms.initial_facts import initial_facts
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.model.analysis.separation import separated, separations
from tamp.planning.model.analysis.transit_actions import Connectors
from tamp.planning.model.objects import Objects
from tamp.planning.model.schema import Schema
from tamp.planning.options import Options

MOVES_IN_SEARCH = 4000
"""How many moves between values the search may see where leaving them out has failed."""


def seen_by_search(schema: Schema, objects: Objects, options: Options) -> tuple[Schema, Connectors]:
    """A problem as the search sees it, and the moves that are left out of it.

    Below a cost all moves must be seen that cost different things; until there is a plan to improve on, none need be.
    """
    by_values = options.max_cost < math.inf and not options.unit_costs and schema.domain.uses_costs
    for part, connectors in _candidates(schema, objects) if options.connectors else ():
        hidden = [c.schema for c in connectors.connectors]
        if not any(options.constraints.bind(a.name) or (by_values and not constant(a.cost)) for a in hidden):
            return part, connectors
    return schema, Connectors(schema, enabled=False)


def may_be_filled_in(schema: Schema, objects: Objects, options: Options) -> frozenset[str]:
    """The actions that a skeleton need not name, whether the search sees them in this run or not."""
    if not options.constraints.alternatives or options.constraints.exact:
        return frozenset()
    return frozenset(c.schema.name for _, moves in _candidates(schema, objects) for c in moves.connectors)


def _candidates(schema: Schema, objects: Objects) -> list[tuple[Schema, Connectors]]:
    """Ways to see a problem without some of its moves, and which these are; the best first."""
    plain = Connectors(schema)
    if plain.connectors:
        return [(schema, plain)]
    given = list(initial_facts(schema, objects, None))
    parts = [separated(schema, part, given) for part in separations(schema, given)]
    return [(part, moves) for part in parts if (moves := Connectors(part)).connectors]


def constant(cost: tuple[Any, ...] | None) -> bool:
    """Whether an action costs the same whatever its arguments are, so that the search knows what it leaves out."""
    return all(isinstance(term, int | float) for term in cost or ())


def few_moves(connectors: Connectors, operators: Collection[GroundOperator]) -> bool:
    """Whether the search could as well see the moves that were left out of it, by the values that operators want."""
    hidden = connectors.connectors
    wanted = {
        (op.schema.name, p[hidden[0].position])
        for op in operators
        for p in op.schema.condition.positive
        if p[0] == connectors.fluent
    }
    values = {op.binding.get(str(t), t) for op in operators for n, t in wanted if n == op.schema.name}
    return len(values) ** 2 * len(hidden) <= MOVES_IN_SEARCH
