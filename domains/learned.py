"""Samplers with a model: read once in each process, before any limit of planning runs."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from functools import cache, wraps
from typing import Any, TypeVar

from tamp.errors import SamplerError

Model = TypeVar("Model")
Sampler = Callable[..., Any]

LOAD = "load"
"""The attribute by which a sampler says what shall happen before the clock starts."""


def with_model(read: Callable[[], Model]) -> Callable[[Callable[..., Any]], Sampler]:
    """Give a sampler a model: it is called as `sampler(context, model, *inputs)`, and serves a stream of those inputs.

    `read` is called once in each process, and its time is no planning time. Every run of a batch has a process of its
    own, so that no result depends on what ran before.

    Args:
        read: makes the model, from a file for instance; whatever it returns.

    Raises:
        SamplerError: as it decorates a function that takes no model.
    """
    once = cache(read)

    def serve(sampler: Callable[..., Any]) -> Sampler:
        @wraps(sampler)
        def call(context: Any, *inputs: Any) -> Any:
            return sampler(context, once(), *inputs)

        taken = inspect.signature(sampler)
        if len(taken.parameters) < 2:
            raise SamplerError(
                f"@with_model: expected a function of (context, model, *inputs), found {sampler.__name__}{taken}"
            )
        context, _, *inputs = taken.parameters.values()
        call.__signature__ = inspect.Signature([context, *inputs])  # type: ignore[attr-defined]
        setattr(call, LOAD, once)
        return call

    return serve


def load_models(samplers: Iterable[Sampler]) -> None:
    """Let those that have a model read it.

    Raises:
        SamplerError: where that fails; names the sampler.
    """
    for sampler in samplers:
        load = getattr(sampler, LOAD, None)
        if load is None:
            continue
        try:
            load()
        except Exception as error:
            told = " ".join(f"{type(error).__name__}: {error}".split())
            name = f"{sampler.__module__}:{getattr(sampler, '__qualname__', sampler)}"
            raise SamplerError(f"the model of sampler {name} cannot be read: {told}") from error
