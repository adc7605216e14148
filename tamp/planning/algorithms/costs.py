"""What actions cost: for a plan with real values exactly, for the search with what is known so far."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from typing import NamedTuple

from tamp.errors import DomainError
from tamp.language import FunctionStream, Variable
from tamp.planning.binding.attempt import BoundStep
from tamp.planning.grounding.operators import GroundOperator
from tamp.planning.model.fact_store import Knowledge
from tamp.planning.model.normal_form import ActionSchema
from tamp.planning.model.objects import Fact, Pattern
from tamp.planning.model.stream_instances import Instance, ground
from tamp.planning.sampling.stream_calls import Sampling

SCALE = 10.0
"""What one unit of cost weighs in the search, where one call of an ordinary stream weighs 1."""

FINE_SCALE = 1000.0
"""The same where plans must be cheap, and nothing is known of what they may cost: streams then weigh nothing."""

RESOLUTION = 1e6
"""What the best plan's cost weighs in the search: costs are whole numbers there."""

LIKELY = 3
"""How many values that streams have given stand for one that is assumed, where its price is guessed."""

UNKNOWN = 1.0
"""What a function is guessed to be of which no value is known."""

MOST = 1e8
"""The most that an action or a plan's bound weighs in the search, whose numbers end at 2**31."""


class Known(NamedTuple):
    """What is known of a function's values: how many there are, what they add up to, and the least of them."""

    number: int
    total: float
    least: float


class Costs:
    """Costs of actions. Where the domain has no costs, or the caller wants unit costs, each action costs 1."""

    def __init__(
        self, knowledge: Knowledge, sampling: Sampling, unit_costs: bool, hidden: frozenset[str] = frozenset()
    ) -> None:
        """`hidden`: the actions that are left out of the search."""
        self._knowledge = knowledge
        self._sampling = sampling
        schema = knowledge.schema
        self.unit = unit_costs or not schema.domain.uses_costs
        self.scale = SCALE
        self._fine = False
        self._most = MOST
        self._guessing = True
        self._hidden = hidden
        self._noted: set[tuple[object, ...]] = set()
        self._known: dict[str, Known] = {}
        self._values = {
            (term.function, *(schema.objects.intern(arg.value) for arg in term.args)): value  # type: ignore[union-attr]
            for term, value in schema.problem.initial_state.values.items()
        }
        for term, value in self._values.items():
            self._note(term, float(value))

    def prefer_cheap(self, limit: float, exact: bool = False) -> None:
        """From now on, let the search see the actions' costs alone, of plans that cost at most `limit`.

        The caller's limit may be far above any plan's cost, as the best plan's is not: `exact`.
        """
        self._fine, self._guessing = True, False
        if 0.0 < limit < math.inf:
            self.scale = RESOLUTION / limit if exact else min(max(FINE_SCALE, RESOLUTION / limit), MOST / limit)
            self._most = 2.0 * self.scale * limit
        else:
            self.scale, self._most = FINE_SCALE, MOST

    def of_plan(self, steps: Iterable[BoundStep]) -> float:
        """The cost of a plan."""
        return sum(self._of(step.schema, step.binding) for step in steps)

    def at_least(self, step: BoundStep, stale: Collection[int] = ()) -> float:
        """The least that an action may cost, nothing but bounds being known of `stale` values."""
        if self.unit:
            return 1.0
        total = 0.0
        for term in step.schema.cost or ():
            fact = (term,) if isinstance(term, int | float) else ground(term, step.binding)
            sure = not any(h in stale for h in fact[1:]) and self._has_value(fact)
            total += term if isinstance(term, int | float) else self._function(fact) if sure else self._bound(fact[0])
        return total

    def searched(self, steps: Iterable[BoundStep], pairs: bool = False) -> int:
        """The cost of a plan as the search sees it where plans must be cheap; `pairs`: as `of_move_between` prices."""
        return sum(self._rounded(self._expected(step, pairs)) for step in steps)

    def _expected(self, step: BoundStep, pairs: bool) -> float:
        """What an action of a plan costs, or is guessed to where it is a move that the search leaves out."""
        if not pairs and self._guessing and step.schema.name in self._hidden:
            return self._guessed(step.schema)
        return self._of(step.schema, step.binding)

    def guess(self, guessing: bool) -> None:
        """From now on, let the search see what is not known at what such things cost in the mean, or at the least."""
        self._guessing = guessing

    def _rounded(self, cost: float) -> int:
        """Never more than what it stands for; what costs more than any plan may is not told apart."""
        return int(min(self.scale * cost, self._most))

    def of_operator(self, operator: GroundOperator) -> int:
        """What the search minimises: the action's cost, and how reluctantly its streams should be used."""
        cost = self._of(operator.schema, operator.binding)
        if self._fine:
            return self._rounded(cost)
        return round(min(self.scale * cost, self._most) + sum(instance.effort for instance in operator.needs))

    def of_move(self, schema: ActionSchema) -> int:
        """What the search pays for an action of any arguments: the least that it may cost, or what is guessed."""
        if self.unit or (self._guessing and self._fine):
            return self._rounded(self._guessed(schema))
        least = sum(term if isinstance(term, int | float) else self._least(str(term[0])) for term in schema.cost or ())
        return self._rounded(least)

    def of_move_between(self, schema: ActionSchema, binding: dict[str, int]) -> int:
        """What the search pays for an action of which only some arguments are known."""
        if self.unit:
            return self._rounded(1.0)
        return self._rounded(sum(self._term_between(term, binding) for term in schema.cost or ()))

    def _term_between(self, term: int | float | Pattern, binding: dict[str, int]) -> float:
        if isinstance(term, int | float):
            return float(term)
        name, functions = str(term[0]), self._knowledge.schema.functions
        if not all(t in binding for t in term[1:] if isinstance(t, str)):
            return self._guess(name)
        fact = ground(term, binding)
        if name not in functions or all(map(self._knowledge.objects.is_real, fact[1:])):
            return self._function(fact) if self._has_value(fact) else self._guess(name)
        known = self._among_given(functions[name], fact[1:], least=1)
        return self._guess(name) if known is None else max(known, self._bound(name))

    def _guessed(self, schema: ActionSchema) -> float:
        """What an action is guessed to cost, whatever its arguments are."""
        if self.unit:
            return 1.0
        return sum(term if isinstance(term, int | float) else self._guess(str(term[0])) for term in schema.cost or ())

    def of_assumed_test(self, test: Instance) -> int:
        """What the search pays for assuming that a test holds."""
        return 0 if self._fine else round(test.effort)

    def _of(self, schema: ActionSchema, binding: dict[str, int]) -> float:
        if self.unit:
            return 1.0
        total = 0.0
        for term in schema.cost or ():
            total += term if isinstance(term, int | float) else self._function(ground(term, binding))
        return total

    def by_values(self, schemas: Iterable[ActionSchema]) -> bool:
        """Whether what actions cost depends on what streams give."""
        terms = [term for schema in schemas for term in schema.cost or () if isinstance(term, tuple)]
        return not self.unit and any(str(term[0]) in self._knowledge.schema.functions for term in terms)

    def _least(self, function: str) -> float:
        """The least value that is known of a function."""
        given = [float(value) for term, value in self._values.items() if term[0] == function]
        if function in self._knowledge.schema.functions:
            given.append(self._bound(function))
        return min(given, default=0.0)

    def _outside(self, function: FunctionStream, handles: tuple[int, ...]) -> Fact | None:
        """A fact of a function's domain that does not hold; what actions change is for their conditions to check."""
        schema, objects = self._knowledge.schema, self._knowledge.objects
        values = dict(zip(function.inputs, handles, strict=True))
        for atom in function.domain:
            args = (values[t] if isinstance(t, Variable) else objects.intern(t.value) for t in atom.args)
            fact = (atom.predicate, *args)
            if atom.predicate not in schema.fluents | schema.derived and not self._knowledge.usable(fact):
                return fact
        return None

    def _has_value(self, term: Fact) -> bool:
        """Whether a function may be asked for a value, or one is given."""
        function = self._knowledge.schema.functions.get(term[0])
        return term in self._values or function is None or self._outside(function, term[1:]) is None

    def _function(self, term: tuple[object, ...]) -> float:
        name, handles = str(term[0]), tuple(h for h in term[1:] if isinstance(h, int))
        known = self._values.get(term)
        if known is not None:
            return float(known)
        functions = self._knowledge.schema.functions
        if name not in functions:
            return 0.0
        if all(map(self._knowledge.objects.is_real, handles)):
            lacking = self._outside(functions[name], handles)
            if lacking is not None:
                text = self._knowledge.objects.text
                raise DomainError(
                    f"function {name!r} has no value for {text((name, *handles))}: "
                    f"{text(lacking)} of its :domain does not hold, and init gives no value"
                )
            value = self._sampling.function(name, handles)
            self._note(term, value)
            return value
        if not self._guessing:
            return self._bound(name)
        known = self._among_given(functions[name], handles) if self._fine else None
        return self._guess(name) if known is None else max(known, self._bound(name))

    def _among_given(self, function: FunctionStream, handles: tuple[int, ...], least: int = LIKELY) -> float | None:
        """The mean of a function for values that streams have given, in place of those that they may give.

        None where there are fewer than `least` of its values yet, of the `LIKELY` that are looked at.
        """
        values: list[float] = []
        for number in range(LIKELY):
            given = tuple(self._given(handle, number) for handle in handles)
            real = tuple(handle for handle in given if handle is not None)
            if len(real) == len(given) and self._has_value((function.name, *real)):
                values.append(self._function((function.name, *real)))
            elif len(values) + LIKELY - 1 - number < least:
                return None
        return sum(values) / len(values)

    def _given(self, handle: int, number: int) -> int | None:
        """What a stream has given for a placeholder, the results taken in turn; None where it has given nothing."""
        origin: Instance | None = self._knowledge.objects.origin(handle)
        if origin is None:
            return handle
        inputs = tuple(self._given(h, number) for h in origin.inputs)
        real = tuple(h for h in inputs if h is not None)
        instance = self._knowledge.find(origin.external, real) if len(real) == len(inputs) else None
        if instance is None or not instance.results:
            return None
        return instance.results[number % len(instance.results)][origin.placeholders.index(handle)]

    def _guess(self, function: str) -> float:
        """What is guessed of a function: the mean of what is known of it once there is a plan, before that the least.

        Without a plan dear assumptions would bar the way to one: all that matters is that more of them cost more.
        """
        known = self._known.get(function)
        guess = UNKNOWN if known is None else known.total / known.number if self._fine else known.least
        return max(guess, self._bound(function))

    def _note(self, term: tuple[object, ...], value: float) -> None:
        """Let a value of a function count for what others are guessed to be."""
        if term not in self._noted:
            self._noted.add(term)
            known = self._known.get(str(term[0]), Known(0, 0.0, value))
            self._known[str(term[0])] = Known(known.number + 1, known.total + value, min(known.least, value))

    def _bound(self, function: str) -> float:
        """The least value of a function, as far as it is known."""
        info = self._knowledge.schema.problem.info.get(function)
        return info.bound if info is not None else 0.0
