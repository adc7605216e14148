"""Which moves the search leaves out of a problem, to be filled in between the actions that it finds."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

from tamp.planning.algorithms.initial_facts import initial_facts
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.model.objects import Objects
from tamp.planning.model.schema import Schema
from tamp.planning.model.separation import separated, separations
from tamp.planning.model.transit_actions import Connectors
from tamp.planning.options import Options

MOVES_IN_SEARCH = 4000
"""How many moves between values the search may see where leaving them out has failed."""


def seen_by_search(schema: Schema, objects: Objects, options: Options) -> tuple[Schema, Connectors]:
    """A problem as the search sees it, and the moves that are left out of it.

    Below a cost all moves must be seen that cost different things; until there is a plan to improve on, none need be.
    """
    by_values = options.max_cost < math.inf and not options.unit_costs and schema.domain.uses_costs
    forbidden = {str(p[0]).lower() for p in options.constraints.forbidden}
    plain = Connectors(schema, options.connectors)
    made = [(schema, plain)]
    if options.connectors and not plain.connectors:
        given = list(initial_facts(schema, objects, None))
        parts = [separated(schema, part, given) for part in separations(schema, given)]
        made = [(part, Connectors(part)) for part in parts] + made
    for part, connectors in made:
        hidden = [c.schema for c in connectors.connectors]
        barred = any(action.name in forbidden or (by_values and not constant(action.cost)) for action in hidden)
        if hidden and not barred:
            return part, connectors
    return schema, Connectors(schema, enabled=False)


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
