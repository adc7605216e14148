"""What samplers give back, checked against what their streams promise."""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tamp.errors import SamplerError
from tamp.planning.schema import External


@dataclass(frozen=True)
class Certified:
    """What a sampler yields to certify more than its stream promises.

    A stream that may do so yields all its outputs like this, from the first on: without it, a problem may be taken for
    infeasible that only further facts could save.

    Attributes:
        outputs: the outputs as it would otherwise yield them; None to certify facts alone.
        facts: further facts about any values; their predicates must not be changed by actions.
    """

    outputs: Any
    facts: tuple[tuple[Any, ...], ...] = ()


def answer_of(external: External, answer: Any) -> Any:
    """What a test answered: () where it holds, None where not, or what it certifies besides.

    Raises:
        SamplerError: where it is neither.
    """
    if isinstance(answer, Certified):
        return answer
    if not isinstance(answer, bool | np.bool_):
        raise SamplerError(f"test {external.name!r}: expected True or False, found {answer!r}")
    return () if answer else None


def output_iterator(external: External, made: Any) -> Iterator[Any]:
    """The outputs of a call, one at a time.

    Raises:
        SamplerError: where it returned nothing that can be iterated over.
    """
    if not isinstance(made, Iterable):
        raise SamplerError(
            f"stream {external.name!r}: expected a generator function that yields one output at a time, "
            f"but the function returned {made!r}"
        )
    return iter(made)


def output_values(external: External, output: Any) -> tuple[Any, ...]:
    """The values of one output, one for each output of the stream.

    Raises:
        SamplerError: where their number differs.
    """
    count = len(external.outputs)
    if count == 0:
        return ()
    values = (output,) if count == 1 else output
    if not isinstance(values, tuple | list) or len(values) != count:
        names = ", ".join(name[1:] for name in external.outputs)
        raise SamplerError(
            f"stream {external.name!r}: expected to yield a tuple of {count} outputs ({names}), found {output!r}"
        )
    return tuple(values)


def function_value(name: str, value: Any) -> float:
    """The value of a function.

    Raises:
        SamplerError: where it is no finite number of 0 or more.
    """
    if not isinstance(value, numbers.Real) or not 0 <= float(value) < float("inf"):
        raise SamplerError(f"function {name!r}: expected a finite number of 0 or more, found {value!r}")
    return float(value)
