"""Pages that are made from the program itself: `<!-- fields: ... -->` and `<!-- commands -->` in the manual."""

from __future__ import annotations

import argparse
import dataclasses
import inspect
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Put in what a comment of a page asks for."""
    markdown = re.sub(r"<!-- commands -->", lambda _: "\n".join(_commands()), markdown)
    markdown = re.sub(r"<!-- task fields -->", lambda _: "\n".join(_task_fields()), markdown)
    robots = Path(__file__).parents[1] / "robots"
    for comment, name in (("robot", "panda"), ("second robot", "ur5e_2f85")):
        robot = (robots / name / "robot.yaml").read_text(encoding="utf-8")
        markdown = markdown.replace(f"<!-- {comment} -->", robot.rstrip())
    markdown = re.sub(r"<!-- result fields -->", lambda _: "\n".join(_result_fields()), markdown)
    return _with_mathematics(markdown)


def _with_mathematics(markdown: str) -> str:
    """LaTeX between backslashed parentheses or brackets as MathML, which browsers show without any script."""
    from latex2mathml.converter import convert

    markdown = re.sub(r"\\\((.+?)\\\)", lambda m: convert(m[1].strip()), markdown, flags=re.DOTALL)
    return re.sub(r"\\\[(.+?)\\\]", lambda m: convert(m[1].strip(), display="block"), markdown, flags=re.DOTALL)


def _commands() -> Iterator[str]:
    """The help of every command."""
    from tamp.cli import parser

    for name, command in _subcommands(parser()).items():
        yield f"\n## tamp {name}\n\n```text\n{_help(command)}```\n"
        for inner, sub in _subcommands(command).items():
            yield f"\n### tamp {name} {inner}\n\n```text\n{_help(sub)}```\n"


def _help(parser: argparse.ArgumentParser) -> str:
    parser.formatter_class = lambda prog: argparse.HelpFormatter(prog, width=100)
    return parser.format_help()


def _subcommands(parser: argparse.ArgumentParser) -> Mapping[str, argparse.ArgumentParser]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return action.choices
    return {}


def _task_fields() -> Iterator[str]:
    """A table for each part of the task schema."""
    from tamp.task.files.schema import TaskModel

    schema = TaskModel.model_json_schema()
    for title, part in {"task": schema, **schema.get("$defs", {})}.items():
        if "properties" not in part:
            continue
        yield f"\n### {title.removesuffix('Model')}\n\n{' '.join(part.get('description', '').split())}\n"
        yield "| field | type | default | meaning |\n|---|---|---|---|"
        for name, field in part["properties"].items():
            default = "required" if name in part.get("required", ()) else f"`{field.get('default')}`"
            meaning = " ".join(field.get("description", "").split())
            yield f"| `{name}` | {_kind(field)} | {default} | {meaning} |"


def _kind(field: Mapping[str, Any]) -> str:
    if "$ref" in field:
        return str(field["$ref"]).rpartition("/")[2].removesuffix("Model")
    if options := field.get("anyOf") or field.get("oneOf"):
        return " or ".join(dict.fromkeys(_kind(option) for option in options))
    if field.get("type") == "array":
        items = field.get("items") or (field.get("prefixItems") or [{}])[0]
        return f"list of {_kind(items)}"
    return str(field.get("const") or field.get("type") or "any")


def _result_fields() -> Iterator[str]:
    """Fields of a result with what its docstring says of them."""
    from tamp.results import Result

    said = inspect.getdoc(Result) or ""
    told: dict[str, str] = {}
    for names, text in re.findall(r"^    ([a-z_0-9, ]+): (.*(?:\n        .*)*)", said, re.MULTILINE):
        told.update(dict.fromkeys(names.split(", "), " ".join(text.split())))
    yield "| field | type | meaning |\n|---|---|---|"
    for field in dataclasses.fields(Result):
        kind = str(field.type).replace("|", "or")
        yield f"| `{field.name}` | {kind} | {told.get(field.name, '')} |"
