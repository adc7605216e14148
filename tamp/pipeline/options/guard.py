"""Samplers from outside, held to their streams wherever the pipeline calls them, in sentences that name them."""

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import wraps
from typing import Any, get_origin

from tamp.clock import TimeUp
from tamp.domains.catalog import contract, type_name
from tamp.domains.domain import Domain
from tamp.errors import SamplerError
from tamp.language import Stream
from tamp.planning import Certified
from tamp.planning.sampling import faults

Sampler = Callable[..., Any]


def guarded(domain: Domain, samplers: Mapping[str, Sampler], own: Collection[str]) -> dict[str, Sampler]:
    """The samplers, with those of `own` guarded: what they raise or yield wrongly is a SamplerError.

    Args:
        domain: whose streams they serve.
        samplers: one for each stream.
        own: streams whose samplers do not come with the domain.
    """
    streams = {stream.name: stream for stream in domain.stream_file.streams}
    return {name: _guarded(domain, streams[name], s) if name in own else s for name, s in samplers.items()}


def _guarded(domain: Domain, stream: Stream, sampler: Sampler) -> Sampler:
    if not stream.outputs:

        @wraps(sampler)
        def answer(context: Any, *inputs: Any) -> Any:
            return _run(stream, sampler, inputs, lambda: sampler(context, *inputs))

        return answer
    kinds = tuple(contract(domain, stream).outputs.values())

    @wraps(sampler)
    def draw(context: Any, *inputs: Any) -> Any:
        made = _run(stream, sampler, inputs, lambda: sampler(context, *inputs))
        if not isinstance(made, Iterator):
            return made  # refused by the planner, which says what it expected
        return _fitting(stream, sampler, inputs, made, kinds)

    return draw


def _fitting(
    stream: Stream, sampler: Sampler, inputs: tuple[Any, ...], made: Iterator[Any], kinds: tuple[Any, ...]
) -> Iterator[Any]:
    end = object()
    while (output := _run(stream, sampler, inputs, lambda: next(made, end))) is not end:
        values = output.outputs if isinstance(output, Certified) else output
        for value, kind in zip((values,) if len(kinds) == 1 else values or (), kinds, strict=False):
            if values is not None and _is_class(kind) and not isinstance(value, kind):
                told = f"stream {stream.name!r}: expected to yield a {type_name(kind)}, found {reprlib.repr(value)}"
                raise faults.unfit(SamplerError(told), sampler, made)
        yield output


def _is_class(kind: Any) -> bool:
    return inspect.isclass(kind) and get_origin(kind) is None and kind not in (int, float, bool, Any)


def _run(stream: Stream, sampler: Sampler, inputs: tuple[Any, ...], call: Callable[[], Any]) -> Any:
    try:
        return call()
    except GeneratorExit:
        raise
    except BaseException as error:
        if faults.interrupts(sampler, error):
            raise
        shown = ", ".join(str(i) if isinstance(i, str) else type(i).__name__ for i in inputs)
        if isinstance(error, TimeUp):
            raise TimeUp(faults.late(stream.name, sampler, shown, error)) from None
        raise faults.raised(stream.name, sampler, shown, error) from error
