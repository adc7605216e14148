"""The service's pages: templates filled with what the board says; whatever people wrote is escaped."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from datetime import datetime, timezone
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from tamp.contest.api import client
from tamp.contest.sandbox.isolation import visible
from tamp.results import percent

if TYPE_CHECKING:
    from jinja2 import Environment

STATIC = {"style.css": "text/css", "contest.js": "text/javascript"}
"""What pages refer to, beside pictures."""


def page(name: str, **data: Any) -> str:
    """A template of `templates/`, filled."""
    return _environment().get_template(name).render(data)


def static(name: str) -> str:
    """A file of `STATIC`."""
    return _read(name)


def sample() -> str:
    """A solution to begin with."""
    return files("tamp.contest.samples").joinpath("scripted.py").read_text(encoding="utf-8")


def standard_api() -> dict[str, list[tuple[str, str]]]:
    """What a solution may call and read, as its own documentation says: title -> what, and its first sentences."""
    titles = {
        "goal": client.Goal,
        "goal.objects[name]": client.GoalObject,
        "robot": client.Robot,
        "robot.camera": client.Cameras,
        "robot.camera.frame(name)": client.Frame,
        "robot.arm": client.Arm,
        "robot.arm.state()": client.ArmState,
        "robot.gripper": client.Gripper,
    }
    return {title: [*_attributes(kind), *_methods(kind)] for title, kind in titles.items()}


def _attributes(kind: type) -> Iterator[tuple[str, str]]:
    """Of a class, those that its docstring lists: `name: text`, indented lines go on."""
    _, _, listed = (inspect.getdoc(kind) or "").partition("Attributes:\n")
    entries: list[str] = []
    for line in listed.splitlines():
        if line.startswith("     ") and entries:
            entries[-1] += f" {line.strip()}"
        elif line.strip():
            entries.append(line.strip())
    yield from ((name, text.strip()) for name, _, text in (entry.partition(":") for entry in entries))


def _methods(kind: type) -> Iterator[tuple[str, str]]:
    for name, value in vars(kind).items():
        if name.startswith("_"):
            continue
        text = (inspect.getdoc(value) or "").split("\n\nArgs:")[0]
        if isinstance(value, property):
            yield name, text
        elif inspect.isfunction(value):
            yield f"{name}({', '.join(map(_argument, [*inspect.signature(value).parameters.values()][1:]))})", text


def _argument(parameter: inspect.Parameter) -> str:
    default = "" if parameter.default is parameter.empty else f"={parameter.default}"
    return f"{parameter.name}{default}"


def _read(name: str) -> str:
    return files("tamp.contest.service.web").joinpath("templates", name).read_text(encoding="utf-8")


@cache
def _environment() -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    made = Environment(
        loader=FunctionLoader(_read), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    made.filters |= {"cm": _cm, "share": _share, "moment": _moment, "size": _size, "printed": _printed}
    return made


def _cm(value: float | None) -> str:
    return "–" if value is None else f"{100 * value:.2f}"


def _share(value: float | None) -> str:
    return "–" if value is None else percent(value).replace("%", " %")


def _printed(log: str) -> str:
    """What a solution printed, its lines as they are, and each with all that it has in sight."""
    return "\n".join(visible(line.expandtabs()) for line in log.splitlines())


def _size(kib: int) -> str:
    """KiB in the largest unit that it is a whole number of."""
    units = ("KiB", "MiB", "GiB")
    power = max(power for power in range(len(units)) if kib % 1024**power == 0)
    return f"{kib // 1024**power} {units[power]}"


def _moment(value: float) -> str:
    return datetime.fromtimestamp(value, timezone.utc).strftime("%d %b %Y %H:%M UTC")
