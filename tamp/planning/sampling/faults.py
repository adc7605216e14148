"""What a sampler does wrong, in one sentence that names the sampler, where it stands, and its stream."""

from __future__ import annotations

import dis
import inspect
import reprlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

from tamp.errors import SamplerError
from tamp.planning.sampling.optimizers import Component
from tamp.planning.wrappers import Adapted


def written(sampler: Callable[..., Any]) -> Callable[..., Any]:
    """The function that somebody wrote, below wrappers, optimizers' streams and arguments given in advance."""
    if isinstance(sampler, partial):
        return written(sampler.func)
    if isinstance(sampler, Component):
        return written(sampler.procedure)
    if isinstance(sampler, Adapted) and sampler.function is not None:
        return written(sampler.function)
    return sampler


def named(sampler: Callable[..., Any]) -> str:
    """How a sampler is addressed: "package.module:function"."""
    sampler = written(sampler)
    module, name = getattr(sampler, "__module__", None), getattr(sampler, "__qualname__", None)
    return f"{module}:{name}" if module and name else reprlib.repr(sampler)


def home(sampler: Callable[..., Any], generator: Any = None) -> str:
    """File and line of a sampler: where its generator stands, or else where it begins; empty where nobody knows."""
    frame = getattr(generator, "gi_frame", None)
    if frame is not None and not isinstance(sampler, Adapted | Component):  # otherwise the generator is its wrapper's
        return f"{frame.f_code.co_filename}:{frame.f_lineno}"
    code = getattr(inspect.unwrap(written(sampler)), "__code__", None)
    return "" if code is None else f"{code.co_filename}:{code.co_firstlineno}"


def line_of(sampler: Callable[..., Any], trace: TracebackType | None) -> str:
    """The innermost line of the sampler's own file on the way to an exception."""
    own, found = home(sampler).rpartition(":")[0], ""
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == own:
            found = f"{own}:{trace.tb_lineno}"
        trace = trace.tb_next
    return found or home(sampler)


def interrupts(sampler: Callable[..., Any], error: BaseException) -> bool:
    """Whether the user interrupts, and not a sampler by a statement of its own that raises KeyboardInterrupt."""
    trace = error.__traceback__
    if not isinstance(error, KeyboardInterrupt) or trace is None:
        return False
    while trace.tb_next is not None:
        trace = trace.tb_next
    code = trace.tb_frame.f_code
    theirs = code.co_filename == home(sampler).rpartition(":")[0]
    return not (theirs and dis.opname[code.co_code[trace.tb_lasti]] == "RAISE_VARARGS")


def raised(stream: str, sampler: Callable[..., Any], inputs: str, error: BaseException) -> SamplerError:
    """That a sampler raised, or tried to end the program."""
    what = "tried to end the program" if isinstance(error, SystemExit) else f"raised {_said(error)}"
    return _error(
        f"the sampler of stream {stream!r} {what} for ({inputs})", sampler, line_of(sampler, error.__traceback__)
    )


def unfit(error: SamplerError, sampler: Callable[..., Any], generator: Any = None) -> SamplerError:
    """What is wrong with an output, with who gave it."""
    return _error(" ".join(str(error).split()), sampler, home(sampler, generator))


def late(stream: str, sampler: Callable[..., Any], inputs: str, error: BaseException) -> str:
    """That a sampler went on past the limit for planning."""
    where = line_of(sampler, error.__traceback__)
    return (
        f"the sampler of stream {stream!r} went on past the limit for ({inputs}): {named(sampler)} at {_short(where)}"
    )


def _error(sentence: str, sampler: Callable[..., Any], where: str) -> SamplerError:
    return SamplerError(f"{sentence}: {named(sampler)}{f' at {_short(where)}' if where else ''}")


def _said(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split()).rstrip(": ")[:300]


def _short(where: str) -> str:
    """A path as seen from where the user stands, where it is below."""
    file, _, line = where.rpartition(":")
    path = Path(file)
    return f"{path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path}:{line}"
