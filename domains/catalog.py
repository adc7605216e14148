"""The installed domains, and what each of their streams takes and gives as Python types.

A domain is a package in domains/ whose `DOMAIN` is a `tamp.domains.domain.Domain`; one from elsewhere is named by its
package, or "package.module:NAME", or by the name that an entry point or a folder gives it (tamp.plugins). Types are
those that the default samplers are annotated with.
"""

from __future__ import annotations

import importlib.util
import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any, get_args, get_type_hints

from tamp import plugins
from tamp.domains.domain import Domain
from tamp.domains.samplers import Sampler, load_sampler
from tamp.errors import DomainError
from tamp.language import Stream
from tamp.language.sexpr import suggest


@dataclass(frozen=True)
class Contract:
    """A stream's variables with their Python types; `Any` where the default sampler says none."""

    inputs: Mapping[str, Any]
    outputs: Mapping[str, Any]

    def __str__(self) -> str:
        given = f"({_listed(self.inputs)})"
        return f"{given} -> {_listed(self.outputs)}" if self.outputs else f"{given} -> bool"


def domain_names() -> tuple[str, ...]:
    """Names of the installed domains, sorted; those that entry points and TAMP_DOMAINS bring are among them."""
    return tuple(sorted(_installed()))


def _installed() -> dict[str, str]:
    """Name -> "package.module" or "package.module:NAME"."""
    own = {path.parent.name: f"tamp.domains.{path.parent.name}" for path in _root().glob("*/domain.pddl")}
    named, packages = plugins.addresses("domains"), {path.parent.name: path for path in _packages()}
    known = {**own, **named}
    for name in sorted(known.keys() & packages.keys()):
        raise DomainError(f"domain {name!r} is there twice: {known[name]} and {packages[name].parent}")
    for name in sorted(own.keys() & named.keys()):
        raise DomainError(f"domain {name!r} is there twice: {own[name]} and the entry point {named[name]}")
    return known | {name: name for name in packages}


def _packages() -> Iterator[Path]:
    for folder in plugins.folders("domains"):
        yield from sorted(folder.glob("*/__init__.py"))


def module_of(name: str) -> str:
    """The module in which a domain is looked for; nothing is imported."""
    return _installed().get(name, name).partition(":")[0]


@lru_cache(maxsize=16)
def load_domain(name: str) -> Domain:
    """The domain of a name: an installed one, or "package.module" or "package.module:NAME" from anywhere.

    Raises:
        DomainError: where there is none of that name, or its files cannot be read.
    """
    plugins.make_importable("domains")
    installed = _installed()
    module_name, _, attribute = installed.get(name, name).partition(":")
    if name not in installed and "." not in name and ":" not in name and importlib.util.find_spec(name) is None:
        own = "one of your own is named by its package, or as package.module:NAME"
        hint = suggest(name, installed, "installed domains")
        raise DomainError(f"unknown domain {name!r} ({own}){hint}")
    domain = getattr(plugins.imported(module_name, f"domain {name!r}", DomainError), attribute or "DOMAIN", None)
    if not isinstance(domain, Domain):
        found = "nothing" if domain is None else type(domain).__name__
        raise DomainError(f"domain {name!r}: {module_name}.{attribute or 'DOMAIN'} must be a Domain, found {found}")
    _ = domain.stream_file  # read now, so that mistakes show before anything runs
    _check_samplers(domain)
    return domain


def _check_samplers(domain: Domain) -> None:
    streams = {stream.name for stream in domain.stream_file.streams}
    if missing := sorted(streams - domain.samplers.keys()):
        raise DomainError(f"domain {domain.name}: no skill says what serves the stream {', '.join(missing)}")
    if strange := sorted(domain.samplers.keys() - streams):
        raise DomainError(
            f"domain {domain.name}: a sampler is given for {', '.join(strange)}, which is no stream of it"
        )


def contract(domain: Domain, stream: Stream) -> Contract:
    """The types of a stream's variables, from the annotations of its default sampler."""
    sampler = load_sampler(domain.samplers[stream.name], stream.name)
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
