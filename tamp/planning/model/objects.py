"""Objects as small integers: any Python value, and the placeholders that stand for values not sampled yet."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

from tamp.language import Constant
from tamp.planning.model.content import content, own_copy

Fact = tuple[Any, ...]
"""A predicate's name in lower case, followed by handles."""

Pattern = tuple[str | int, ...]
"""A predicate followed by terms: variables are strings, objects are handles."""


PART = " "
"""Between a fluent's name and what tells a part of it from the rest: see `Part`."""


@dataclass(frozen=True)
class Part:
    """The atoms of a fluent that have one of some objects at a position; the planner has its own name for them."""

    fluent: str
    position: int
    things: frozenset[int]

    @property
    def name(self) -> str:
        """What the planner calls them."""
        return f"{self.fluent}{PART}{self.position}"

    def inner(self, fact: Fact) -> Fact:
        """A fact by the name that it has inside the planner."""
        mine = fact[0] == self.fluent and fact[self.position] in self.things
        return (self.name, *fact[1:]) if mine else fact


class Objects:
    """Gives each object a handle, an integer in order of first appearance, and a key that is the same in every run."""

    def __init__(self) -> None:
        self._handles: dict[Constant, int] = {}
        self._alike: dict[Hashable, int] = {}
        self._values: list[Any] = []
        self._keys: list[str] = []
        self._origins: list[Any] = []

    def intern(self, value: Any, key: str | None = None) -> int:
        """The handle of a value; equal values share one.

        Values without a hash, such as arrays, share one where streams gave them and they consist of the same; those
        that the problem gives stand for themselves alone. What streams give is kept as it is now: a sampler may yield
        one container again and again, each time with something else in it.

        Args:
            value: any object.
            key: of a value that a stream gave. A string is its own key: what is sampled for it does not depend on what
                else a problem speaks of.
        """
        constant = Constant(value)
        handle = self._handles.get(constant)
        if handle is None:
            inside = content(value) if key is not None and constant.by_identity else None
            handle = self._alike.get(inside) if inside is not None else None
            if handle is None:
                given = value if isinstance(value, str) else f"given {len(self._values)}"
                value = value if inside is None else own_copy(value)
                handle = self._new(value, given if key is None else key, None)
            if inside is not None:
                self._alike[inside] = handle
            self._handles[Constant(self._values[handle])] = handle
        return handle

    def __len__(self) -> int:
        """How many handles there are: 0 to this, without it."""
        return len(self._values)

    def find(self, value: Any) -> int | None:
        """The handle of a value; None where it has none yet."""
        return self._handles.get(Constant(value))

    def placeholder(self, key: str, origin: Any) -> int:
        """A new optimistic object, an output of the stream instance `origin`."""
        return self._new(None, key, origin)

    def _new(self, value: Any, key: str, origin: Any) -> int:
        self._values.append(value)
        self._keys.append(key)
        self._origins.append(origin)
        return len(self._values) - 1

    def value(self, handle: int) -> Any:
        """The Python value of a handle."""
        return self._values[handle]

    def key(self, handle: int) -> str:
        """What identifies the object in every run of the same problem, whatever was sampled before it."""
        return self._keys[handle]

    def origin(self, handle: int) -> Any:
        """The stream instance that a placeholder is an output of; None for a real object."""
        return self._origins[handle]

    def real(self) -> list[int]:
        """Handles of all objects that are no placeholders."""
        return [handle for handle, origin in enumerate(self._origins) if origin is None]

    def is_real(self, handle: int) -> bool:
        """Whether the handle stands for a value."""
        return self._origins[handle] is None

    def values_of(self, fact: Fact) -> Fact:
        """A fact by the problem's names, with values in place of handles."""
        return (fact[0].partition(PART)[0], *(self._values[handle] for handle in fact[1:]))

    def text(self, fact: Fact) -> str:
        """A fact for people to read; placeholders begin with a hash sign."""
        return f"({' '.join((str(fact[0]).partition(PART)[0], *map(self.name, fact[1:])))})"

    def name(self, handle: int) -> str:
        """An object for people to read: short values as they are, others by their type and handle."""
        if not self.is_real(handle):
            return f"#{handle}"
        value = self._values[handle]
        short = str(value) if isinstance(value, str | int | float | bool) else ""
        return short if 0 < len(short) <= 24 else f"{type(value).__name__}@{handle}"
