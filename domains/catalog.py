"""The installed domains, and what each of their streams takes and gives as Python types.

A domain is a package in domains/ with `domain.pddl`, `stream.pddl`, `DEFAULT_SAMPLERS` (stream -> "module:function")
and a function NAME_problem(workspace, samplers, configuration); VARIANTS may hold more such functions, for problems in
which streams have something to do that are seldom used. Types are those that the default samplers are annotated with.
"""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, get_args, get_type_hints

from tamp.domains.samplers import Sampler, load_sampler
from tamp.errors import DomainError, SamplerError
from tamp.language import Domain, Stream, StreamFile, parse_domain, parse_streams
from tamp.planning import Problem


@dataclass(frozen=True)
class DomainEntry:
    """An installed domain.

    Attributes:
        name: its folder's name.
        domain: actions, predicates and axioms.
        streams: what its samplers take and promise.
        samplers: stream name -> "package.module:function".
        problems: (workspace, samplers, configuration) -> a planning problem; the first is the usual one.
    """

    name: str
    domain: Domain
    streams: StreamFile
    samplers: Mapping[str, str]
    problems: tuple[Callable[..., Problem], ...]

    def stream(self, name: str) -> Stream:
        """The stream called `name`.

        Raises:
            SamplerError: where there is none; lists those that there are.
        """
        for stream in self.streams.streams:
            if stream.name == name.lower():
                return stream
        raise SamplerError(f"no stream {name!r}; {self.name} has {', '.join(s.name for s in self.streams.streams)}")


@dataclass(frozen=True)
class Contract:
    """A stream's variables with their Python types; `Any` where the default sampler says none."""

    inputs: Mapping[str, Any]
    outputs: Mapping[str, Any]

    def __str__(self) -> str:
        given = f"({_listed(self.inputs)})"
        return f"{given} -> {_listed(self.outputs)}" if self.outputs else f"{given} -> bool"


def domain_names() -> tuple[str, ...]:
    """Names of the installed domains, sorted."""
    return tuple(sorted(path.parent.name for path in _root().glob("*/domain.pddl")))


def load_domain(name: str) -> DomainEntry:
    """Read an installed domain.

    Raises:
        DomainError: where there is none of that name, or its files cannot be read.
    """
    if name not in domain_names():
        raise DomainError(f"unknown domain {name!r}; installed are {', '.join(domain_names())}")
    folder, module = _root() / name, importlib.import_module(f"tamp.domains.{name}")
    domain = parse_domain(folder / "domain.pddl")
    streams = parse_streams(folder / "stream.pddl", domain)
    problems = (getattr(module, f"{name}_problem"), *getattr(module, "VARIANTS", ()))
    return DomainEntry(name, domain, streams, module.DEFAULT_SAMPLERS, problems)


def contract(entry: DomainEntry, stream: Stream) -> Contract:
    """The types of a stream's variables, from the annotations of its default sampler."""
    sampler = load_sampler(entry.samplers[stream.name], stream.name)
    hints = get_type_hints(sampler)
    taken = _parameters(sampler)[1:]
    inputs = {str(v): hints.get(name, Any) for v, name in zip(stream.inputs, taken, strict=True)}
    return Contract(inputs, dict(zip(map(str, stream.outputs), _yielded(stream, hints), strict=True)))


def type_name(kind: Any) -> str:
    """A type as a reader would write it."""
    return getattr(kind, "__name__", str(kind))


def _parameters(sampler: Sampler) -> list[str]:
    return list(inspect.signature(sampler).parameters)


def _yielded(stream: Stream, hints: Mapping[str, Any]) -> tuple[Any, ...]:
    """One type for each output; a sampler is annotated with Iterator[T], or Iterator[tuple[...]] for several."""
    if not stream.outputs:
        return ()
    (item,) = get_args(hints.get("return")) or (Any,)
    if len(stream.outputs) == 1:
        return (item,)
    return get_args(item) or (Any,) * len(stream.outputs)


def _listed(types: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}: {type_name(kind)}" for name, kind in types.items())


def _root() -> Path:
    return Path(str(files("tamp"))) / "domains"
