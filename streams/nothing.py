"""A sampler that gives nothing, to switch a stream off: `--sampler sample-regrasp=tamp.streams.nothing:nothing`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tamp.streams.context import Context


def nothing(context: Context, *inputs: Any) -> Iterator[Any]:
    """Yield nothing, for any stream with outputs."""
    context.fail("this stream is switched off")
    yield from ()
