"""The form of what a sampler gives: as many outputs as its stream has, each of its type."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from tamp.domains.catalog import Contract, type_name
from tamp.language import Stream

LONGEST = 60
"""Characters of a value in a sentence."""


def malformed(value: Any, stream: Stream, contract: Contract) -> Iterator[str]:
    """Yield what is wrong with the form of something yielded, or of a test's answer.

    Args:
        value: as it came.
        stream: whose sampler gave it.
        contract: the stream's types.
    """
    if stream.is_test:
        if type(value).__name__ not in ("bool", "bool_"):
            yield f"a test must answer True or False, not {value!r}"
        return
    value = getattr(value, "outputs", value)  # planning.Certified carries facts beside the outputs
    kinds = contract.outputs
    if len(kinds) > 1 and (not isinstance(value, tuple | list) or len(value) != len(kinds)):
        yield f"expected a tuple of {len(kinds)} outputs ({', '.join(kinds)}), found {short(value)}"
        return
    values = (value,) if len(kinds) == 1 else value
    for (name, kind), part in zip(kinds.items(), values, strict=True):
        if kind is not Any and isinstance(kind, type) and not isinstance(part, kind):
            yield f"{name} must be a {type_name(kind)}, found {short(part)}"


def shown(values: Sequence[Any]) -> str:
    """Inputs in a sentence."""
    return f"({', '.join(map(short, values))})"


def short(value: Any) -> str:
    """A value in a sentence."""
    text = " ".join(repr(value).split())
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
