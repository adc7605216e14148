"""What samplers have worked out and drawn, kept for all searches of a run: nothing kept depends on who asked first."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from tamp import clock
from tamp.streams.context import Detached

if TYPE_CHECKING:
    from tamp.streams.context import Context

T = TypeVar("T")
Draw = Callable[[Detached], Iterator[T | None]]
"""Begins a sampler, with a context that knows no plan and no deadline; None stands for a pause."""


WORK = 4  # steps without an output between two pauses


class SampleCache:
    """Values that follow from a task's geometry, and the samples drawn so far, of one run.

    Whoever keeps something here names all that it depends on in its key, besides the shapes, the robot and the table,
    which are the same for the whole run.
    """

    def __init__(self) -> None:
        self._values: dict[Hashable, Any] = {}
        self._drawn: dict[Hashable, _Drawn] = {}

    def value(self, key: Hashable, work_out: Callable[[], T]) -> T:
        """What `work_out` returns; it is called once for each key."""
        if key not in self._values:
            self._values[key] = work_out()
        found: T = self._values[key]
        return found

    def learn(self, key: Hashable, found: object) -> None:
        """Have `value` return what somebody else has found out."""
        self._values[key] = found

    def drawn(self, key: Hashable, begin: Callable[[], tuple[Detached, Iterator[Any]]]) -> _Drawn:
        """What has been drawn for a key; `begin` is called once for each, and again after an interruption."""
        if key not in self._drawn:
            self._drawn[key] = _Drawn(begin)
        return self._drawn[key]


@dataclass
class _Drawn:
    """What a sampler has given so far, None where it paused, and where more comes from."""

    begin: Callable[[], tuple[Detached, Iterator[Any]]]
    items: list[Any] = field(default_factory=list)
    heard: list[int] = field(default_factory=list)
    context: Detached | None = None
    source: Iterator[Any] | None = None

    def item(self, index: int) -> Any:
        """The item of a number, drawn if nobody has asked for it yet; _END where there is none."""
        while index >= len(self.items):
            if self.items and self.items[-1] is _END:
                return _END
            # A sampler that is interrupted has ended, though it had more to give: it begins anew the next time.
            source, self.source = self.source or self._begun(), None
            self.items.append(next(source, _END))
            self.heard.append(len(self.reasons))
            self.source = source
        return self.items[index]

    @property
    def reasons(self) -> list[str]:
        """All that the sampler has said."""
        return [] if self.context is None else self.context.reasons

    def _begun(self) -> Iterator[Any]:
        self.context, source = self.begin()
        for _ in self.items:
            next(source)  # it gives the same again
        return source


def recalled(context: Context, name: str, inputs: tuple[Hashable, ...], reads: Any, draw: Draw[T]) -> Iterator[T]:
    """Yield what `draw` yields; what was drawn before for the same is not drawn again.

    The samples are a function of the name, the inputs, what stands in `reads` and the seed, whoever asks first and
    whatever was asked before: the generator that they are drawn by is derived from just those.

    Args:
        context: of this search. Its deadline ends only this reading of the samples.
        name: of the sampler.
        inputs: of the sampler; their `repr` tells them apart.
        reads: the part of the workspace that the sampler may depend on; it sees no other.
        draw: begins the sampler, with a context that knows no plan and no deadline. It yields None where nothing has
            come for a while, so that a reader whose deadline is past can stop there.
    """
    steps = stepwise(context, name, inputs, reads, draw)
    while clock.now() <= context.deadline:
        try:
            item = next(steps)
        except StopIteration:
            return
        if item is not None:
            yield item


def stepwise(
    context: Context, name: str, inputs: tuple[Hashable, ...], reads: Any, draw: Draw[T]
) -> Iterator[T | None]:
    """The same with a None wherever `draw` paused, for every reader, whatever the time is."""
    key = (name, inputs, context.seed, reads.placements)

    def begin() -> tuple[Detached, Iterator[T | None]]:
        detached = Detached(reads, context.seed, generator_of(key))
        return detached, draw(detached)

    drawn = reads.cache.drawn(key, begin)
    told = index = 0
    while True:
        item = drawn.item(index)
        for reason in drawn.reasons[told : drawn.heard[index]]:
            context.fail(reason)
        told = drawn.heard[index]
        if item is _END:
            return
        yield item
        index += 1


def pausing(context: Context, steps: Iterable[T | None]) -> Iterator[T]:
    """The items of a sampler that stands None for work done without one, until the deadline of a search.

    Where no plan waits for an item, it pauses after some of that work, and None is yielded: so a round through all
    streams does not wait for the dearest of them.
    """
    worked = 0
    for item in steps:
        if item is not None:
            worked = 0
            yield item
            continue
        if clock.now() > context.deadline:
            return
        worked += 1
        if context.brief and worked % WORK == 0:
            context.pause()
            yield cast("T", None)  # whoever is brief knows of it


def generator_of(key: Hashable) -> np.random.Generator:
    """The random generator of a key: the same in every process, as far as `repr` of the key is."""
    digest = hashlib.blake2b(repr(key).encode(), digest_size=16).digest()
    return np.random.default_rng(int.from_bytes(digest, "little"))


class _End:
    """What a source that has ended gives."""


_END = _End()
