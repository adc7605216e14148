"""Imports that are put off until they are used: libraries draw and fit splines, we do not."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any


@contextmanager
def deferred(*names: str) -> Iterator[None]:
    """Let the modules that are imported within hold stand-ins for some others, which are imported once they are used.

    TOPPRA imports Matplotlib's interface for plots (0.6 s) to draw what is never drawn here, and SciPy's splines
    (0.1 s) for paths that are not ours. What is taken out of such a module within is a stand-in too, which can be
    called, and asked for what belongs to it. Afterwards `import` finds the true modules, as it does for all who import
    them elsewhere; one that is loaded already is left as it is.

    Args:
        names: full names, each package before its modules, such as "matplotlib", "matplotlib.pyplot".
    """
    if any(name in sys.modules for name in names):
        yield
        return
    stands_in = {name: _Deferred(name) for name in names}
    for name, module in stands_in.items():
        package, _, last = name.rpartition(".")
        if package in stands_in:
            setattr(stands_in[package], last, module)
    sys.modules.update(stands_in)
    try:
        yield
    finally:
        for name, module in stands_in.items():
            module.__dict__["_within"] = False
            if sys.modules.get(name) is module:
                del sys.modules[name]


class _Deferred(ModuleType):
    """Stands for a module: looks up there what is asked of it."""

    _within = True

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)  # what the import system asks of every module
        if self._within:
            return _Taken(self, name)
        if sys.modules.get(self.__name__) is self:
            del sys.modules[self.__name__]
        return getattr(importlib.import_module(self.__name__), name)


class _Taken:
    """Stands for what was taken out of a module: looks it up there once it is called, or asked for something."""

    def __init__(self, module: _Deferred, name: str) -> None:
        self._module, self._name = module, name

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return getattr(self._module, self._name)(*arguments, **options)

    def __getattr__(self, name: str) -> Any:
        return getattr(getattr(self._module, self._name), name)
