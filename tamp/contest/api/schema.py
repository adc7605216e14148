"""What may be said on the contest's socket: each call and each answer, field by field. Both sides check by it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from tamp.contest.api.wire import Message, ProtocolError

VERSION = 1
"""Of the API; a solution's client says it first."""


@dataclass(frozen=True)
class Text:
    """Text of at most so many characters."""

    most: int = 100

    def wrong(self, value: Any) -> str:
        """Why a value is none; empty where it is one."""
        if type(value) is not str:
            return "is not text"
        if any("\ud800" <= character <= "\udfff" for character in value):
            return "holds half a character (a surrogate), which no library takes"
        return "" if len(value) <= self.most else f"is longer than {self.most} characters"


@dataclass(frozen=True)
class Number:
    """A finite number within bounds."""

    low: float = -math.inf
    high: float = math.inf

    def wrong(self, value: Any) -> str:
        """Why a value is none."""
        if type(value) not in (int, float) or not abs(value) < 1e300:
            return "is not a finite number"
        return "" if self.low <= value <= self.high else f"is {value}, not between {self.low} and {self.high}"


@dataclass(frozen=True)
class Flag:
    """True or false."""

    def wrong(self, value: Any) -> str:
        """Why a value is none."""
        return "" if type(value) is bool else "is not true or false"


@dataclass(frozen=True)
class Numbers:
    """A list of finite numbers: so many, or up to `most`."""

    count: int | None = None
    most: int = 64

    def wrong(self, value: Any) -> str:
        """Why a value is none."""
        if type(value) is not list or not len(value) <= self.most or self.count not in (None, len(value)):
            return f"is not a list of {self.count if self.count is not None else f'up to {self.most}'} numbers"
        return next((wrong for number in value if (wrong := Number().wrong(number))), "")


@dataclass(frozen=True)
class Items:
    """A list of objects of the same fields; a field that may be null says so in `optional`."""

    of: Mapping[str, Any]
    optional: frozenset[str] = frozenset()
    most: int = 200

    def wrong(self, value: Any) -> str:
        """Why a value is none."""
        if type(value) is not list or len(value) > self.most:
            return f"is not a list of at most {self.most}"
        for index, item in enumerate(value):
            if type(item) is not dict or set(item) != set(self.of):
                return f"[{index}] does not have exactly {', '.join(self.of)}"
            for name, kind in self.of.items():
                wrong = "" if item[name] is None and name in self.optional else kind.wrong(item[name])
                if wrong:
                    return f"[{index}].{name} {wrong}"
        return ""


@dataclass(frozen=True)
class Array:
    """An array of finite numbers of a type, none beyond `bound`; None in the shape is any length up to `most`."""

    dtype: str
    shape: tuple[int | None, ...]
    most: int = 4096
    bound: float = math.inf

    def wrong(self, value: Any) -> str:
        """Why an array is none."""
        if value.dtype != np.dtype(f"<{self.dtype}") or value.ndim != len(self.shape):
            return f"is not an array of type {self.dtype} with {len(self.shape)} dimensions"
        if any(
            have > self.most if want is None else have != want
            for have, want in zip(value.shape, self.shape, strict=True)
        ):
            wanted = ", ".join(f"up to {self.most}" if want is None else str(want) for want in self.shape)
            return f"has shape {value.shape}, not ({wanted})"
        if self.dtype != "u1" and not np.isfinite(value).all():
            return "holds numbers that are not finite"
        if self.bound < math.inf and np.abs(value).max(initial=0.0) > self.bound:
            return f"holds a number beyond {self.bound:g}"
        return ""


@dataclass(frozen=True)
class Form:
    """What a message carries; fields are all there, arrays but those in `optional`."""

    fields: Mapping[str, Any] = field(default_factory=dict)
    arrays: Mapping[str, Array] = field(default_factory=dict)
    optional: frozenset[str] = frozenset()


_VECTOR = Array("f8", (None,), 64, bound=1e3)
_POSE = Array("f8", (4, 4), bound=1e2)
_SPEED = Number(0.01, 1.0)

OBJECT = {
    "name": Text(), "mesh": Text(200), "visual": Text(200), "mass": Number(0.0), "friction": Number(0.0),
    "pose": Numbers(16), "on": Text(), "inside": Text(),
}  # fmt: skip
"""An object of the goal: its mesh files by name, and one of pose (4 x 4, row by row), on and inside, or none."""

CALLS: Mapping[str, Form] = MappingProxyType(
    {
        "hello": Form({"version": Number()}),
        "state": Form(),
        "frame": Form({"camera": Text()}),
        "tf": Form({"parent": Text(), "child": Text()}),
        "move_joints": Form({"speed": _SPEED}, {"q": _VECTOR}),
        "move_pose": Form({"speed": _SPEED, "straight": Flag()}, {"T_world_tool": _POSE}),
        "follow": Form(
            arrays={"times": Array("f8", (None,), bound=1e6), "positions": Array("f8", (None, None), bound=1e3),
                    "velocities": Array("f8", (None, None), bound=1e3)},
            optional=frozenset({"velocities"}),
        ),
        "go_to": Form({"width": Number(0.0, 1.0), "effort": Number(0.0, 1000.0)}),
        "wait": Form({"seconds": Number(0.0, 60.0)}),
        "finished": Form(),
        "raised": Form({"error": Text(2000)}),
    }
)  # fmt: skip
"""What a solution may say."""

_TIME = {"time_left": Number()}
_STATE = Form(
    {**_TIME, "width": Number()},
    {"q": _VECTOR, "T_world_tool": _POSE},
)

ANSWERS: Mapping[str, Form] = MappingProxyType(
    {
        "welcome": Form(
            {
                **_TIME,
                "task": Text(), "robot": Text(), "stroke": Number(),
                "cameras": Items({"name": Text()}), "joints": Items({"name": Text()}),
                "table": Numbers(5),
                "objects": Items(OBJECT, frozenset({"visual", "pose", "on", "inside"})),
            },
            {"home": _VECTOR, "lower": _VECTOR, "upper": _VECTOR, "velocity": _VECTOR},
        ),
        "state": _STATE,
        "frame": Form(
            _TIME,
            {
                "color": Array("u1", (None, None, 3)), "depth": Array("f4", (None, None)),
                "robot": Array("u1", (None, None)), "K": Array("f8", (3, 3)), "T_world_camera": _POSE,
            },
        ),
        "tf": Form(_TIME, {"T_parent_child": _POSE}),
        "done": Form(_TIME),
        "refused": Form({**_TIME, "reason": Text(1000)}),
        "over": Form({"reason": Text(1000)}),
    }
)  # fmt: skip
"""What the server may answer: one kind for each question, "refused" for what cannot be done, "over" for the end."""


def check(message: Message, forms: Mapping[str, Form]) -> Message:
    """The message, where it has one of the forms; else ProtocolError says what is wrong."""
    form = forms.get(message.kind)
    if form is None:
        raise ProtocolError(f"there is no message {message.kind[:40]!r}; valid are {', '.join(forms)}")
    if set(message.fields) != set(form.fields):
        raise ProtocolError(f"{message.kind} takes the fields {_names(form.fields)}, not {_names(message.fields)}")
    if not set(form.arrays) - form.optional <= set(message.arrays) <= set(form.arrays):
        raise ProtocolError(f"{message.kind} takes the arrays {_names(form.arrays)}, not {_names(message.arrays)}")
    kinds = {**form.fields, **form.arrays}
    for name, value in {**message.fields, **message.arrays}.items():
        wrong = kinds[name].wrong(value)
        if wrong:
            raise ProtocolError(f"{message.kind}: {name} {wrong}")
    return message


def _names(things: Mapping[str, Any]) -> str:
    return ", ".join(name[:40] for name in list(things)[:12]) or "none"
