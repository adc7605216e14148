"""Which function serves each stream: the one nearest to the user wins."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Mapping
from typing import Any

from tamp import plugins
from tamp.errors import SamplerError, meant

Sampler = Callable[..., Any]


def resolve_samplers(*layers: Mapping[str, str | Sampler]) -> dict[str, Sampler]:
    """Merge layers of samplers; the first layer names all streams, later ones replace single entries.

    Args:
        layers: stream name -> function, or "package.module:function"; from the domain's defaults to the nearest.

    Raises:
        SamplerError: for a stream that the domain does not have, or a function that cannot be imported.
    """
    defaults = layers[0]
    chosen: dict[str, str | Sampler] = dict(defaults)
    for layer in layers[1:]:
        for stream, sampler in layer.items():
            if stream not in defaults:
                hint = meant(stream, defaults)
                raise SamplerError(f"no stream {stream!r}; {hint}the domain has {', '.join(sorted(defaults))}")
            chosen[stream] = sampler
    return {stream: _function(sampler, stream) for stream, sampler in chosen.items()}


def _function(sampler: str | Sampler, stream: str) -> Sampler:
    """A sampler as it is or by its address; SamplerError where it is neither."""
    if isinstance(sampler, str):
        return load_sampler(sampler, stream)
    if not callable(sampler):
        valid = 'valid are a function and "package.module:function"'
        raise SamplerError(f"sampler for {stream}: {reprlib.repr(sampler)} is no function; {valid}")
    return sampler


def load_sampler(address: str, stream: str) -> Sampler:
    """Import the function that "package.module:function" names, or an installed sampler's name.

    Modules in folders of TAMP_SAMPLERS are found too; installed names are entry points of the group `tamp.samplers`.

    Raises:
        SamplerError: says which part of the address is wrong, or where its module fails.
    """
    if ":" not in address and address in (named := plugins.addresses("samplers")):
        address = named[address]
    module_name, colon, function_name = address.partition(":")
    if not colon or not function_name or not all(module_name.split(".")):
        others = f", nor an installed sampler: {', '.join(named)}" if ":" not in address and named else ""
        raise SamplerError(f"sampler for {stream}: {address!r} is not of the form package.module:function{others}")
    plugins.make_importable("samplers")
    module = plugins.imported(module_name, f"sampler for {stream}", SamplerError)
    function = getattr(module, function_name, None)
    if not callable(function):
        hint = meant(function_name, (name for name in dir(module) if callable(getattr(module, name, None))))
        raise SamplerError(
            f"sampler for {stream}: {module_name} has no function {function_name!r}; {hint}".rstrip("; ")
        )
    sampler: Sampler = function
    return sampler
