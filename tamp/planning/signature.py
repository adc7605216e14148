"""Do samplers fit their streams? Checked when a problem is built, so that a mistake shows before any search."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Mapping
from typing import Any

from tamp.errors import SamplerError
from tamp.language import FunctionStream, PredicateStream, Stream, StreamFile


def check_samplers(streams: StreamFile, samplers: Mapping[str, Callable[..., Any]], info: Mapping[str, Any]) -> None:
    """Check that each stream has a function that takes a context and the stream's inputs, and that all names are known.

    Raises:
        SamplerError: naming the stream, what was expected and what was found.
    """
    externals: dict[str, Stream | FunctionStream | PredicateStream] = {}
    externals.update({s.name: s for s in streams.streams})
    externals.update({f.name: f for f in streams.functions})
    externals.update({p.name: p for p in streams.predicates})
    for kind, names in (("sampler", samplers), ("info", info)):
        for name in names:
            if name not in externals:
                near = difflib.get_close_matches(name, externals, n=1)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                raise SamplerError(f"{kind} for unknown stream {name!r}; there are: {', '.join(externals)}{hint}")
    for name, external in externals.items():
        if name not in samplers:
            raise SamplerError(f"stream {name!r} has no sampler; given are: {', '.join(samplers) or 'none'}")
        check_sampler(external, samplers[name])


def check_sampler(external: Stream | FunctionStream | PredicateStream, sampler: Callable[..., Any]) -> None:
    """Check that a function takes a context and a stream's inputs.

    Raises:
        SamplerError: says what was expected and what was found.
    """
    inputs = tuple(str(variable)[1:] for variable in external.inputs)
    expected = f"sampler of stream {external.name!r}: expected a function of ({', '.join(('context', *inputs))})"
    if not callable(sampler):
        raise SamplerError(f"{expected}, found {sampler!r}")
    try:
        signature = inspect.signature(sampler)
    except (TypeError, ValueError):
        return  # functions written in C do not all tell what they take
    try:
        signature.bind(*range(len(inputs) + 1))
    except TypeError as error:
        found = f"{getattr(sampler, '__name__', repr(sampler))}{signature}"
        raise SamplerError(f"{expected}, found {found}: {error}") from None
