"""Samplers written for PDDLStream, as samplers of this planner.

PDDLStream's samplers take no context and give tuples of outputs, also where there is only one; its `stream_map` wraps
each by what kind of function it is, and holds functions and predicates bare. The wrappers here have the same names:
`Problem(..., samplers=from_stream_map(stream_map))` takes such a map as it is. Where a stream has `:fluents`, its
function gets those that hold as the keyword argument `fluents`. Where a generator yields a `WildOutput` in place of a
list, anything with lists `values` and `facts`, the facts are certified with the outputs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import count
from typing import Any

from tamp.errors import SamplerError
from tamp.planning.context import Context
from tamp.planning.outputs import Certified

Outputs = tuple[Any, ...] | list[Any]


@dataclass(frozen=True)
class Adapted:
    """A sampler that was wrapped: called as this planner does, with a context first."""

    sampler: Callable[..., Any]

    def __call__(self, context: Context, *inputs: Any) -> Any:
        """What the stream gets for its inputs."""
        return self.sampler(*inputs, **({"fluents": context.fluents} if context.sees_fluents else {}))


def from_stream_map(stream_map: Mapping[str, Callable[..., Any]]) -> dict[str, Adapted]:
    """The samplers of a `stream_map`: those that are wrapped, and bare ones.

    A bare one is a function of a `:function` or `:predicate`, or a generator function that yields lists of tuples.
    """
    return {name: made if isinstance(made, Adapted) else _bare(made) for name, made in stream_map.items()}


def from_list_gen_fn(generate: Callable[..., Iterable[Any]]) -> Adapted:
    """A generator function that yields a list of tuples, or a wild output, at a time; an empty one for "not yet"."""
    return Adapted(lambda *inputs, **fluents: _one_by_one(generate(*inputs, **fluents)))


def from_gen_fn(generate: Callable[..., Iterable[Outputs | None]]) -> Adapted:
    """A generator function that yields a tuple of outputs at a time; None for "nothing yet"."""
    return from_list_gen_fn(lambda *inputs, **fluents: map(_listed, generate(*inputs, **fluents)))


def from_list_fn(compute: Callable[..., Iterable[Outputs]]) -> Adapted:
    """A function that returns a list of tuples: all that there are."""
    return from_list_gen_fn(lambda *inputs, **fluents: iter([compute(*inputs, **fluents)]))


def from_fn(compute: Callable[..., Outputs | None]) -> Adapted:
    """A function that returns a tuple of outputs; None where there are none."""
    return from_list_fn(lambda *inputs, **fluents: _listed(compute(*inputs, **fluents)))


def from_sampler(sample: Callable[..., Outputs | None], max_attempts: float = math.inf) -> Adapted:
    """A function that returns a new tuple of outputs, or None, each of the `max_attempts` times that it is called."""

    def generate(*inputs: Any, **fluents: Any) -> Iterator[Outputs | None]:
        attempts = count()
        while next(attempts) < max_attempts:
            yield sample(*inputs, **fluents)

    return from_gen_fn(generate)


def from_test(test: Callable[..., Any]) -> Adapted:
    """A function that says yes or no, for a stream without outputs."""
    return Adapted(lambda *inputs, **fluents: bool(test(*inputs, **fluents)))


def _bare(function: Callable[..., Any]) -> Adapted:
    def sampler(*inputs: Any, **fluents: Any) -> Any:
        made = function(*inputs, **fluents)
        return _one_by_one(made) if isinstance(made, Iterator) else made

    return Adapted(sampler)


def _one_by_one(generated: Iterable[Any]) -> Iterator[Any]:
    """The outputs of lists and wild outputs, and None for each that is empty."""
    for several in generated:
        if hasattr(several, "facts"):
            facts = tuple(map(tuple, several.facts))
            yield from (Certified(outputs, facts) for outputs in [*map(_plain, several.values)] or [None])
        else:
            yield from [*map(_plain, several)] or [None]


def _listed(outputs: Outputs | None) -> list[Outputs]:
    return [] if outputs is None else [outputs]


def _plain(outputs: Outputs) -> Any:
    """Outputs as streams yield them here: one by itself, several as a tuple."""
    if not isinstance(outputs, tuple | list):
        raise SamplerError(
            f"expected a tuple of outputs such as (x,), as PDDLStream's samplers give, found {outputs!r}"
        )
    return outputs[0] if len(outputs) == 1 else tuple(outputs)
