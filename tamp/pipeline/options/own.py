"""Strategies and searches of a user's own, by "package.module:NAME" or by the name that an installed package gives one.

Entry points of the groups `tamp.strategies` and `tamp.searches` give such names.
"""

from __future__ import annotations

import inspect
import json
import reprlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal, cast

from tamp.errors import TampError, meant, told
from tamp.plugins import addresses, imported

if TYPE_CHECKING:
    from tamp.planning.search.best_first import Search
    from tamp.planning.strategies.strategy import Strategy

Kind = Literal["strategies", "searches"]
ONE: dict[Kind, str] = {"strategies": "strategy", "searches": "search"}


def load_strategy(name: str, built_in: Sequence[str]) -> Strategy:
    """A strategy of the stream planner's that does not come along.

    Args:
        name: "package.module:Class", whose options are then its defaults, or that of an instance; or an installed name.
        built_in: the names of those that come along, to be told with what is valid.

    Raises:
        TampError: where there is none, its module fails, it cannot be asked as a strategy is, or its
            options cannot be recorded.
    """
    from tamp.planning.strategies.strategy import misfit, record

    def unfit(found: Any) -> str:
        if wrong := misfit(found):
            return wrong
        strange = [(name, value) for name, value in record(found).items() if not _recordable(value)]
        valid = "valid are finite numbers, strings, None, and lists and dictionaries of them"
        told = [f"its option {n} is {reprlib.repr(v)}, which a run's record cannot hold; {valid}" for n, v in strange]
        return "".join(told[:1])

    return cast("Strategy", _loaded("strategies", name, built_in, unfit))


def _recordable(value: Any) -> bool:
    """Whether a value can be written as JSON."""
    try:
        json.dumps(value, allow_nan=False)
    except (TypeError, ValueError):
        return False
    return True


def load_search(name: str, built_in: Sequence[str]) -> Search:
    """A classical search that does not come along: a function, a class that is made without arguments, or an instance.

    Raises:
        TampError: where there is none, its module fails, or it cannot be called as a search is.
    """
    from tamp.planning.search.best_first import misfit

    return cast("Search", _loaded("searches", name, built_in, misfit))


def _loaded(kind: Kind, name: Any, built_in: Sequence[str], misfit: Callable[[Any], str]) -> Any:
    if not isinstance(name, str):
        valid = "valid is its name, so that it is recorded: package.module:NAME, where NAME may be an instance"
        raise TampError(f"{ONE[kind]} is {reprlib.repr(name)}; {valid}")
    what = f"{ONE[kind]} {name!r}"
    module, attribute = _address(kind, name, built_in)
    found = getattr(imported(module, what, TampError), attribute, None)
    if found is None:
        raise TampError(f"{what}: the module {module!r} has no {attribute!r}")
    if inspect.isclass(found):
        try:
            found = found()
        except Exception as error:
            instead = "name an instance that the module makes of it"
            raise TampError(f"{what}: the class cannot be made without arguments: {told(error)}; {instead}") from error
    if wrong := misfit(found):
        raise TampError(f"{what}: {wrong}")
    return found


def _address(kind: Kind, name: str, built_in: Sequence[str]) -> tuple[str, str]:
    """Module and attribute; TampError where the name has neither the form of an address nor is an installed one."""
    offered = addresses(kind) if ":" not in name else {}
    if twice := offered.keys() & set(built_in):
        raise TampError(f"entry points tamp.{kind}: {min(twice)!r} is the name of one that comes along; take another")
    module, colon, attribute = offered.get(name, name).partition(":")
    if not (colon and attribute and all(module.split("."))):
        known = (*built_in, *offered)
        valid = f"{meant(name, known)}valid are {', '.join(known)}, and package.module:NAME for one of your own"
        raise TampError(f"unknown {ONE[kind]} {name!r}; {valid}")
    return module, attribute
