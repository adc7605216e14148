"""PDDLStream's solvers as scripts call them: with arguments by position, in the order that they have there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tamp.planning import solve
from tamp.planning.problem import Solution


def by_position(name: str, order: tuple[str, ...], **fixed: Any) -> Callable[..., Solution]:
    """A solver that takes a problem and arguments in an order, or by their names; `fixed`: what it gives itself."""

    def solving(problem: Any, *given: Any, **options: Any) -> Solution:
        if len(given) > len(order):
            raise TypeError(
                f"{name}: by position there are: problem, {', '.join(order)}; found {len(given) + 1} arguments"
            )
        placed = dict(zip(order, given, strict=False))
        if twice := sorted(placed.keys() & options.keys()):
            raise TypeError(f"{name}: {', '.join(twice)}: given by position and by name")
        return solve(problem, **{**fixed, **placed, **options})

    solving.__name__ = solving.__qualname__ = name
    solving.__doc__ = (
        f"`tamp.planning.solve`, as PDDLStream's scripts call it: {name}(problem, {', '.join(order)}, ...)."
    )
    return solving
