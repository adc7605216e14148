"""The service's pages: templates filled with what the board says; whatever people wrote is escaped."""

from __future__ import annotations

from datetime import datetime, timezone
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

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


def _read(name: str) -> str:
    return files("tamp.contest.service.web").joinpath("templates", name).read_text(encoding="utf-8")


@cache
def _environment() -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    made = Environment(
        loader=FunctionLoader(_read), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    made.filters |= {"cm": _cm, "share": _share, "moment": _moment}
    return made


def _cm(value: float | None) -> str:
    return "–" if value is None else f"{100 * value:.2f}"


def _share(value: float | None) -> str:
    return "–" if value is None else f"{100 * value:.1f} %"


def _moment(value: float) -> str:
    return datetime.fromtimestamp(value, timezone.utc).strftime("%d %b %Y %H:%M UTC")
