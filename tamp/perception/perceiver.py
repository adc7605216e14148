"""What a perceiver is, and how one is named: a plain function from frames and meshes to poses.

def my_perceiver(frames, objects, *, table, seed):
return {name: Estimate(pose, confidence) for name in objects}
"""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from numbers import Real
from types import MappingProxyType
from typing import Any, Protocol

from tamp import clock
from tamp.errors import PartError, TampError, meant, told
from tamp.perception.cameras.camera import FARTHEST, Frame
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


PATIENCE_S, AT_LEAST = 60.0, 10
"""How long a perceiver may take for each object, and for how many at least [real s]: ten times what slow ones need."""

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
        PartError: where it raises, with the line, does not answer for every object with an estimate, or not in time;
            says which.
    """
    takes: Any = perceiver
    patience = PATIENCE_S * max(AT_LEAST, len(objects))
    more = {"expected": expected} if expected and _takes_expected(perceiver) else {}
    try:
        with clock.limits_in("wall"), clock.ended_at(clock.now() + patience):  # one that sleeps uses no processor time
            found = takes(frames, MappingProxyType(dict(objects)), table=table, seed=seed, **more)
    except clock.TimeUp:
        raise PartError(f"the perceiver {address(perceiver)} has not answered within {patience:g} s") from None
    except TampError as error:
        raise PartError(f"the perceiver {address(perceiver)}: {error}{_whence(error)}") from error
    except (Exception, SystemExit) as error:
        raise PartError(f"the perceiver {address(perceiver)} raised {told(error)}") from error
    if wrong := unfit(found, tuple(objects)):
        raise PartError(f"the perceiver {address(perceiver)}: {wrong}")
    # Numbers of other libraries become Python's own, which every file can hold.
    return {
        name: replace(found[name], confidence=float(found[name].confidence), alternatives=(*found[name].alternatives,))
        for name in objects
    }


def _takes_expected(perceiver: Perceiver) -> bool:
    try:
        return "expected" in inspect.signature(perceiver).parameters
    except ValueError:  # what is compiled may not tell
        return False


def _whence(error: TampError) -> str:
    """The innermost line outside of this package that an error comes from; empty where there is none."""
    lines = [
        f" at {frame.f_code.co_filename}:{line}"
        for frame, line in traceback.walk_tb(error.__traceback__)
        if frame.f_globals.get("__name__", "").partition(".")[0] != "tamp"
    ]
    return lines[-1] if lines else ""


def unfit(found: object, names: Collection[str]) -> str:
    """What is wrong with what a perceiver answers for objects; empty where nothing is."""
    if not isinstance(found, Mapping):
        return f"its answer is a {type(found).__name__}, not a mapping of names to estimates"
    if set(found) != set(names):
        return (
            f"names {sorted(map(str, found))}; asked for were {sorted(names)}, what is not seen as Estimate(None, 0.0)"
        )
    return next((f"{name}: {wrong}" for name, estimate in found.items() if (wrong := _unfit(estimate))), "")


def _unfit(estimate: object) -> str:
    if not isinstance(estimate, Estimate):
        return f"is a {type(estimate).__name__}, not an Estimate"
    poses, sure = estimate.alternatives, estimate.confidence
    if not isinstance(estimate.pose, Pose | None):
        return f"its pose is a {type(estimate.pose).__name__}, not a Pose, which Pose.from_matrix makes of a matrix"
    if not isinstance(poses, Sequence):
        return f"its alternatives are a {type(poses).__name__}, not a tuple of poses"
    if strange := [type(pose).__name__ for pose in poses if not isinstance(pose, Pose)]:
        return f"one of its alternatives is a {strange[0]}, not a Pose"
    said = [pose for pose in (estimate.pose, *poses) if pose is not None]
    if any(max(map(abs, pose.xyz)) > FARTHEST for pose in said):
        return f"one of its poses is over {FARTHEST:g} m away; positions are in metres"
    if not isinstance(sure, Real):
        return f"its confidence is a {type(sure).__name__}, not a number"
    if not 0.0 <= float(sure) <= 1.0:
        return f"its confidence {sure} is not in 0..1"
    return "was not seen, yet has a confidence over 0" if estimate.pose is None and sure > 0 else ""


def address(perceiver: Perceiver) -> str:
    """A perceiver's function as "package.module:function"."""
    return f"{getattr(perceiver, '__module__', '?')}:{getattr(perceiver, '__qualname__', type(perceiver).__name__)}"


def misfit(function: object) -> str:
    """Why something cannot be called as a perceiver is; empty where it can."""
    if not callable(function):
        return "is no function"
    if inspect.iscoroutinefunction(function) or inspect.iscoroutinefunction(type(function).__call__):
        return "is an async function; a plain one is asked for, which may call asyncio.run"
    try:
        inspect.signature(function).bind((), {}, table=None, seed=0)
    except TypeError as error:
        return f"must take (frames, objects, *, table, seed): {error}"
    except ValueError:  # what is compiled may not tell what it takes
        return ""
    return ""
