"""Ground operators and axioms: schemas with an object for each variable."""

from __future__ import annotations

from dataclasses import dataclass, field

from tamp.planning.model.normal_form import ActionSchema
from tamp.planning.model.objects import Fact
from tamp.planning.model.stream_instances import Instance


@dataclass(frozen=True)
class GroundEffect:
    """`atom` becomes true or false where `positive` hold and `negative` do not.

    Attributes:
        static, absent: facts without fluents that must and must not hold besides; they may be assumed.
    """

    atom: Fact
    adds: bool
    positive: tuple[Fact, ...] = ()
    negative: tuple[Fact, ...] = ()
    static: tuple[Fact, ...] = ()
    absent: tuple[Fact, ...] = ()


@dataclass(eq=False)
class GroundOperator:
    """An action schema with a handle for each variable of its condition.

    Attributes:
        static: facts without fluents that it rests on; they may be assumed.
        absent: facts without fluents that must not hold.
        positive, negative: fluent and derived atoms of its precondition.
        needs: the instances that it assumes, supports first.
        certain: whether it is known to rest on nothing that is assumed, and on nothing that must be absent.
    """

    schema: ActionSchema
    binding: dict[str, int]
    static: tuple[Fact, ...]
    absent: tuple[Fact, ...]
    positive: tuple[Fact, ...]
    negative: tuple[Fact, ...]
    effects: list[GroundEffect] = field(default_factory=list)
    needs: tuple[Instance, ...] = ()
    certain: bool = False

    @property
    def args(self) -> tuple[int, ...]:
        """Handles of the action's own parameters."""
        return tuple(self.binding[t] if isinstance(t, str) else t for t in self.schema.parameters)


@dataclass(eq=False)
class GroundAxiom:
    """`head` holds where the literals do; `certain` as for operators."""

    head: Fact
    static: tuple[Fact, ...]
    absent: tuple[Fact, ...]
    positive: tuple[Fact, ...]
    negative: tuple[Fact, ...]
    certain: bool = False
