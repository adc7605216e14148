"""What a perceiver is, and how one is named: a plain function from frames and meshes to poses.

def my_perceiver(frames, objects, *, table, seed):
return {name: Estimate(pose, confidence) for name in objects}
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, Protocol

from tamp.errors import TampError, meant
from tamp.perception.cameras.camera import Frame
from tamp.perception.estimate import Estimate
from tamp.perception.rendering.surface import Surface
from tamp.plugins import imported
from tamp.task.model import Table
from tamp.task.pose import Pose


class Perceiver(Protocol):
    """Says where objects are.

    One that also takes `expected`, name -> pose of what is known already, is told it, and may answer sooner for that.

    It is given frames with camera models, name -> mesh of everything that may be there, the table and a seed; it
    answers for every name, with `Estimate(None, 0.0)` for what it does not see. Same seed, same answer.
    """

    def __call__(
        self, frames: Sequence[Frame], objects: Mapping[str, Surface], *, table: Table, seed: int
    ) -> Mapping[str, Estimate]:
        """Object -> estimate."""


PERCEIVERS = {"fit": "tamp.perception.estimation.estimator:estimate_poses"}
"""Installed perceivers by name."""


def load_perceiver(name: str) -> Perceiver:
    """A perceiver by an installed name or as "package.module:function".

    Raises:
        TampError: where there is none, its module fails, with the line, or it cannot be called as a perceiver is.
    """
    address = PERCEIVERS.get(name, name)
    module, colon, function = address.partition(":")
    if not (colon and function and all(module.split("."))):
        valid = f"valid are {', '.join(PERCEIVERS)} and package.module:function"
        raise TampError(f"unknown perceiver {name!r}; {meant(name, PERCEIVERS)}{valid}")
    found = getattr(imported(module, f"perceiver {name!r}", TampError), function, None)
    if found is None:
        raise TampError(f"perceiver {name!r}: the module {module!r} has no {function!r}")
    wrong = misfit(found)
    if wrong:
        raise TampError(f"perceiver {name!r}: {wrong}")
    perceiver: Perceiver = found
    return perceiver


def ask(
    perceiver: Perceiver,
    frames: Sequence[Frame],
    objects: Mapping[str, Surface],
    *,
    table: Table,
    seed: int,
    expected: Mapping[str, Pose] = MappingProxyType({}),
) -> Mapping[str, Estimate]:
    """What a perceiver says; it is told what is expected if it takes that.

    Raises:
        TampError: where it does not answer for every object; says which.
    """
    takes: Any = perceiver
    more = {"expected": expected} if expected and "expected" in inspect.signature(perceiver).parameters else {}
    found: Mapping[str, Estimate] = takes(frames, objects, table=table, seed=seed, **more)
    missing = [name for name in objects if name not in found]
    if missing:
        raise TampError(f"the perceiver {address(perceiver)} says nothing of {', '.join(missing)}")
    return found


def address(perceiver: Perceiver) -> str:
    """A perceiver's function as "package.module:function"."""
    return f"{getattr(perceiver, '__module__', '?')}:{getattr(perceiver, '__qualname__', type(perceiver).__name__)}"


def misfit(function: object) -> str:
    """Why something cannot be called as a perceiver is; empty where it can."""
    if not callable(function):
        return "is no function"
    try:
        inspect.signature(function).bind((), {}, table=None, seed=0)
    except TypeError as error:
        return f"must take (frames, objects, *, table, seed): {error}"
    return ""
