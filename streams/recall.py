"""Samples that are drawn once and kept: whoever asks for the same again, in another search, begins with those."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    import numpy as np

    from tamp.streams.workspace import Context

T = TypeVar("T")


@dataclass
class Detached:
    """The context of whoever asks first, without what only holds for that one search."""

    scene: Any
    rng: np.random.Generator
    deadline: float = math.inf
    fluents: tuple[Any, ...] = ()
    bound: tuple[Any, ...] = ()
    reasons: list[str] = field(default_factory=list)

    def fail(self, reason: str, because: Any = ()) -> None:
        """Remember a reason, for all who ask."""
        self.reasons.append(reason)


@dataclass
class _Drawn:
    """What a sampler has given so far, and where more comes from."""

    context: Detached
    source: Iterator[Any]
    items: list[Any] = field(default_factory=list)


def recalled(context: Context, key: Hashable, draw: Callable[[Detached], Iterator[T | None]]) -> Iterator[T]:
    """Yield what `draw` yields; what was drawn before for the same key is not drawn again.

    Args:
        context: of this search; its scene's memory keeps the samples. Its deadline ends only this reading of them.
        key: names the sampler and everything that its samples depend on.
        draw: begins the sampler; called once for each key, with a context that knows no state and no deadline. It
            yields None where nothing has come for a while, so that a reader whose deadline is past can stop there.
    """
    steps = stepwise(context, key, draw)
    while time.monotonic() <= context.deadline:
        try:
            item = next(steps)
        except StopIteration:
            return
        if item is not None:
            yield item


def stepwise(context: Context, key: Hashable, draw: Callable[[Detached], Iterator[T | None]]) -> Iterator[T | None]:
    """The same with a None wherever `draw` pauses, whatever the time is."""
    memory = context.scene.memory
    if key not in memory:
        first = Detached(context.scene, context.rng)
        memory[key] = _Drawn(first, draw(first))
    drawn: _Drawn = memory[key]
    told = index = 0
    while True:
        item = drawn.items[index] if index < len(drawn.items) else _draw(drawn)
        for reason in drawn.context.reasons[told:]:
            context.fail(reason)
        told = len(drawn.context.reasons)
        if item is _END:
            return
        index += item is not None
        yield item


def _draw(drawn: _Drawn) -> Any:
    """One more sample from the source, None where it pauses, _END where it has ended."""
    item = next(drawn.source, _END)
    if item is not None and item is not _END:
        drawn.items.append(item)
    return item


class _End:
    """What a source that has ended gives."""


_END = _End()
