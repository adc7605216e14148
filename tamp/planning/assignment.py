"""Which values placeholders have while a skeleton is bound, and which choices took them."""

from __future__ import annotations

from collections.abc import Iterable

from tamp.planning.objects import Fact


class Assignment:
    """Values of placeholders; a choice is known by its position among a skeleton's items."""

    def __init__(self) -> None:
        self._values: dict[int, int] = {}
        self._owners: dict[int, list[int]] = {}

    def take(self, position: int, placeholders: Iterable[int], handles: Iterable[int]) -> None:
        """A choice gives placeholders their values."""
        for placeholder, handle in zip(placeholders, handles, strict=True):
            self._values[placeholder] = handle
            self._owners.setdefault(handle, []).append(position)

    def release(self, position: int, placeholders: Iterable[int], handles: Iterable[int]) -> None:
        """A choice takes its values back."""
        for placeholder, handle in zip(placeholders, handles, strict=True):
            self._values.pop(placeholder, None)
            self._owners[handle].remove(position)

    def owners(self, handles: Iterable[int]) -> set[int]:
        """The choices that took any of these values."""
        return {owner for handle in handles for owner in self._owners.get(handle, ())}

    def value(self, handle: int) -> int:
        """What stands for a handle: the value of a placeholder that has one, otherwise itself."""
        return self._values.get(handle, handle)

    def fact(self, fact: Fact) -> Fact:
        """A fact with values for its placeholders."""
        return (fact[0], *[self._values.get(h, h) for h in fact[1:]])

    def binding(self, binding: dict[str, int]) -> dict[str, int]:
        """A binding with values for its placeholders."""
        return {name: self._values.get(h, h) for name, h in binding.items()}
