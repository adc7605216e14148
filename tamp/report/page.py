"""Pages of one file: HTML with its style, plots and pictures inside."""

from __future__ import annotations

from importlib.resources import files
from typing import Any

from tamp.results import percent
from tamp.versions import versions


def render(template: str, **data: Any) -> str:
    """Fill a template of `templates/`; everything is escaped but what `svg` marks as safe."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined
    from markupsafe import Markup

    def source(name: str) -> str:
        return files("tamp.report").joinpath("templates", name).read_text(encoding="utf-8")

    environment = Environment(
        loader=FunctionLoader(source),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"svg": Markup, "percent": percent}
    return environment.get_template(template).render(data, versions=versions())
