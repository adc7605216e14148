"""The user's mistakes, and the outcome that there is no plan; bugs propagate as they are."""

import difflib
import traceback
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any


def nearest(word: object, valid: Iterable[str], alike: float = 0.6) -> str | None:
    """The valid name that a word is nearly, in whatever case; None where it is far from all.

    Args:
        word: what was written.
        valid: what might have been meant.
        alike: how much of both words must be the same, from 0 to 1.
    """
    names = {name.lower(): name for name in valid}
    near = difflib.get_close_matches(str(word).lower(), names, n=1, cutoff=alike)
    return names[near[0]] if near else None


def meant(word: object, valid: Iterable[str], alike: float = 0.6) -> str:
    """The nearest valid name as a question, to stand before what is valid; nothing where none is near.

    Args:
        word: what was written.
        valid: what might have been meant.
        alike: how much of both words must be the same, from 0 to 1.
    """
    near = nearest(word, valid, alike)
    return "" if near is None else f"did you mean {near!r}? "


def told(error: BaseException) -> str:
    """An exception in one line, with the file and line that it comes from."""
    if isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error.msg} at {error.filename}:{error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    last = [frame for frame in frames if not frame.filename.startswith("<frozen ")][-1]  # those only import others
    return f"{' '.join(f'{type(error).__name__}: {error}'.split())} at {last.filename}:{last.lineno}"


class TampError(Exception):
    """Base of every error that one sentence to the user can mend."""


class TaskError(TampError):
    """A task, its meshes or its goals are not usable: says file, line and field, and what would be valid."""


class ModelError(TaskError, ValueError):
    """A pose, a shape or an object cannot be made of what was given: says of what, and what would be valid."""


class DomainError(TampError):
    """A domain or stream file cannot be read: says file, line and column, and what was expected."""


class DomainWarning(UserWarning):
    """A likely slip in a domain or stream file that harms nothing: says file, line and column, and what comes of it."""


class RobotError(TampError):
    """A robot is unknown or its data is incomplete."""


class SamplerError(TampError):
    """A sampler's signature or its outputs do not fit its stream."""


class PartError(TampError):
    """Code of somebody's own, such as a skill, a strategy or a simulator, raises or answers wrongly: says which."""


class PlanError(TampError):
    """A plan file cannot be read: says file and field, and what would be valid."""


class PlanRefusedError(TampError):
    """The checker rejects a plan that was to be carried out: says everything that is wrong with it."""


class PlanningFailure(Exception):  # noqa: N818  no error: an outcome
    """No plan was found within the limits; not a mistake of the user's.

    Attributes:
        status: "timeout", "infeasible" (proven) or "failed".
        report: the planner's report: per stream, how often it was called, succeeded, and why it failed; a sentence
            where there was no search.
        left: goals that no plan reaches -> why, where that is known.
    """

    def __init__(self, status: str, report: object, left: Mapping[str, str] = MappingProxyType({})) -> None:
        reasons = (f"{name}: {why}" for name, why in left.items())
        super().__init__(f"{'; '.join([f'no plan ({status})', *reasons])}\n{report}")
        self.status = status
        self.report = report
        self.left = left

    def __reduce__(self) -> tuple[Any, ...]:
        """By what it was made of: it may come from another process."""
        return type(self), (self.status, self.report, dict(self.left))
