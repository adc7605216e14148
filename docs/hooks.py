"""Parts of pages that are made from the program itself, between `<!-- begin NAME -->` and `<!-- end NAME -->`.

They are kept in the repository, so that the manual reads there without a build; `python docs/hooks.py` writes them
anew, and a test says where they are out of date.
"""

from __future__ import annotations

import argparse
import ast
import dataclasses
import importlib
import inspect
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from textwrap import dedent, indent
from typing import Any

DOCS = Path(__file__).parent


def refreshed(markdown: str) -> str:
    """A page with its generated parts made anew."""

    def part(found: re.Match[str]) -> str:
        name = found["name"]
        names = re.findall(r"^::: (\S+)$", markdown, re.MULTILINE)
        of_names = {"names": _names, "signatures": _signatures}
        lines = "\n".join(of_names[name](names) if name in of_names else _part(name)).strip("\n")
        return f"<!-- begin {name} -->\n\n{lines}\n\n<!-- end {name} -->"

    pattern = r"<!-- begin (?P<name>[a-z0-9_ ]+) -->.*?<!-- end (?P=name) -->"
    return re.sub(pattern, part, markdown, flags=re.DOTALL)


def on_files(files: Any, config: Any) -> Any:
    """Add a page for each tutorial, which is a notebook in the repository."""
    from mkdocs.structure.files import File

    for notebook in sorted((DOCS / "tutorials").glob("*.ipynb")):
        page = f"tutorials/{notebook.stem}.md"
        files.append(File.generated(config, page, content="\n\n".join(_notebook(notebook)) + "\n"))
    return files


def _notebook(path: Path) -> Iterator[str]:
    """A notebook's cells and what they printed, as Markdown."""
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            yield source.replace(".ipynb)", ".md)")
            continue
        yield f"```python\n{source}\n```"
        for output in cell["outputs"]:
            data = output.get("data", {})
            if "image/png" in data:
                yield f"![what the cell shows](data:image/png;base64,{''.join(data['image/png']).strip()})"
            elif text := "".join(output.get("text", data.get("text/plain", ""))).rstrip():
                yield f"```text\n{text}\n```"


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Links to notebooks as links to their pages, formulas as MathML; signatures are left to the site's own plugin."""
    markdown = re.sub(r"<!-- begin signatures -->.*?<!-- end signatures -->", "", markdown, flags=re.DOTALL)
    markdown = re.sub(r"\((\S*tutorials/\w+)\.ipynb\)", r"(\1.md)", markdown)
    return _with_mathematics(markdown)


def _with_mathematics(markdown: str) -> str:
    """LaTeX between backslashed parentheses or brackets as MathML, which browsers show without any script."""
    from latex2mathml.converter import convert

    def inline(found: re.Match[str]) -> str:  # a line that begins with <math> would end the paragraph
        return f"<span>{convert(found[1].strip())}</span>"

    def block(found: re.Match[str]) -> str:
        return f'<div class="formula">{convert(found[1].strip(), display="block")}</div>'

    markdown = re.sub(r"\\\((.+?)\\\)", inline, markdown, flags=re.DOTALL)
    return re.sub(r"\\\[(.+?)\\\]", block, markdown, flags=re.DOTALL)


def _commands() -> Iterator[str]:
    """The help of every command."""
    from tamp.cli import parser

    for name, command in _subcommands(parser()).items():
        yield f"\n## tamp {name}\n\n```text\n{_help(command)}```\n"
        for inner, sub in _subcommands(command).items():
            yield f"\n### tamp {name} {inner}\n\n```text\n{_help(sub)}```\n"


def _help(parser: argparse.ArgumentParser) -> str:
    parser.formatter_class = lambda prog: argparse.HelpFormatter(prog, width=100)
    return re.sub(r"[ \t]+$", "", parser.format_help(), flags=re.MULTILINE)


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


def _names(names: Iterable[str]) -> Iterator[str]:
    """What a page of the API describes: each name with its first sentence; the site has all of it."""
    yield "| name | what it is |\n|---|---|"
    for name in names:
        yield f"| `{name}` | {_gist(_found(name))} |"


def _found(name: str) -> Any:
    """A module, or what a module has, by its full name."""
    module, _, attribute = name.rpartition(".")
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        return getattr(importlib.import_module(module), attribute)


def _signatures(names: Iterable[str]) -> Iterator[str]:
    """How what a page of the API describes is called and what its fields are: of modules, classes and functions."""
    for name in names:
        found = _found(name)
        members = [found]
        if inspect.ismodule(found):
            public = [(word, thing) for word, thing in vars(found).items() if not word.startswith("_")]
            here = [(word, thing) for word, thing in public if getattr(thing, "__module__", "") == name]
            members = [thing for word, thing in here if word == getattr(thing, "__name__", "")]
        for thing in members:
            if inspect.isclass(thing) or inspect.isfunction(thing):
                lines = _class(thing) if inspect.isclass(thing) else (_head(thing), indent(_said(thing), "    "))
                yield "\n".join((f"\n### {thing.__name__}\n\n```text", *lines, "```"))


def _class(thing: type) -> Iterator[str]:
    """What a class says of itself, then how each of its methods is called and what that gives."""
    yield _said(thing)
    for name, member in vars(thing).items():
        if name in getattr(thing, "__dataclass_fields__", ()):  # a function that is a field's default
            continue
        is_value = isinstance(member, property | cached_property)
        function = getattr(member, "fget", None) or getattr(member, "func", None) or getattr(member, "__func__", member)
        if not name.startswith("_") and inspect.isfunction(function):
            head = _head(function).replace("(self)", "") if is_value else _head(function)
            yield f"\n{head}\n{indent(_gist(function), '    ')}"


def _said(thing: object) -> str:
    """A whole docstring."""
    return inspect.getdoc(thing) or ""


def _public_names() -> Iterator[str]:
    """Every public name of the package; of functions also how they are called and what they raise."""
    import tamp

    found = {name: getattr(tamp, name) for name in tamp.__all__}
    yield "| name | what it is |\n|---|---|"
    for name, thing in found.items():
        yield f"| `tamp.{name}` | {_gist(thing)} |"
    for name, function in found.items():
        if inspect.isfunction(function):
            yield f"\n### tamp.{name}\n\n```text\n{_head(function)}\n```\n"
            yield from _raised(function)


def _gist(thing: object) -> str:
    """What a docstring says first."""
    return " ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split()).replace("|", "\\|")


def _head(function: Any) -> str:
    """A function's name, arguments and what it returns, as its module has them."""
    source = dedent(inspect.getsource(function))
    (node,) = ast.parse(source).body
    assert isinstance(node, ast.FunctionDef)
    return (
        "\n".join(source.splitlines()[node.lineno - 1 : node.body[0].lineno - 1]).removeprefix("def ").removesuffix(":")
    )


def _raised(function: Any) -> Iterator[str]:
    """What a function's docstring says that it raises."""
    said = re.search(r"^Raises:\n((?: {4}.*\n?)+)", inspect.getdoc(function) or "", re.MULTILINE)
    for entry in re.findall(r"^    (\S.*(?:\n {8}.*)*)", said[1] if said else "", re.MULTILINE):
        names, _, text = " ".join(entry.split()).partition(": ")
        yield f"- raises {', '.join(f'`{name}`' for name in names.split(', '))}: {text}"


def _scenarios() -> Iterator[str]:
    """A table of the built-in scenarios."""
    import yaml

    yield "| scenario | what it shows |\n|---|---|"
    for path in sorted((DOCS.parent / "scenarios").glob("*.yaml")):
        text = path.read_text(encoding="utf-8")
        told = " ".join(line[1:].strip() for line in text.split("\n\n")[0].splitlines() if line.startswith("#"))
        yield f"| `{yaml.safe_load(text).get('name', path.stem)}` | {told} |"


def _tabletop_pddl() -> Iterator[str]:
    """The PDDL that skills of the tabletop build on, as it is."""
    folder = DOCS.parent / "domains" / "tabletop"
    skills = (folder / "skills" / name for name in ("move", "pick_and_place"))
    texts = [(part / f"{file}.pddl").read_text(encoding="utf-8") for part in skills for file in ("domain", "stream")]
    yield "```lisp"
    yield "\n".join([(folder / "domain.pddl").read_text(encoding="utf-8"), *texts]).rstrip()
    yield "```"


def _robot_file(name: str) -> Iterator[str]:
    """A robot's data as they are."""
    text = (DOCS.parent / "robots" / name / "robot.yaml").read_text(encoding="utf-8")
    yield f"```yaml\n{text.rstrip()}\n```"


def _robot(name: str) -> Iterator[str]:
    """What a robot's data say, in a table."""
    import yaml

    data = yaml.safe_load((DOCS.parent / "robots" / name / "robot.yaml").read_text(encoding="utf-8"))
    arm, gripper = data["arm"], data["gripper"]
    near, far = arm["reach"]
    yield "| what | value |\n|---|---|"
    yield f"| joints of the arm | {len(arm['joints'])} |"
    yield f"| it works well from above | {near} to {far} m from the base's axis |"
    yield f"| base | at {tuple(data['base']['xyz'])}, nothing is put within {data['base']['radius']} m of its axis |"
    yield f"| gripper | opens to {1000 * gripper['stroke']:.0f} mm, closes with up to {gripper['force']:g} N |"
    yield f"| pads | {1000 * gripper['pad'][1]:.0f} mm wide, {1000 * gripper['pad'][2]:.0f} mm along the approach |"
    yield f"| limits of position | {'its own, below' if 'lower' in arm else 'the URDF has them'} |"
    yield f"| limits of velocity | {'its own, below' if 'velocity' in arm else 'the URDF has them'} |"
    yield f"| URDF | `{data['urdf']}` |"
    if "attach" in gripper:
        yield f"| the gripper's URDF | `{gripper['attach']['urdf']}` |"


def _simulators() -> Iterator[str]:
    """The simulators that come with the program."""
    from tamp.execution.simulators import SIMULATORS

    yield "| name | its library | installed by |\n|---|---|---|"
    for name, entry in SIMULATORS.items():
        extra = f"`pip install 'tabletop-tamp[{entry.extra}]'`" if entry.extra else "always, where it has wheels"
        yield f"| [`{name}`]({name}.md) | `{entry.library}` | {extra} |"


def _perceivers() -> Iterator[str]:
    """The installed perceivers."""
    from tamp.perception.perceiver import PERCEIVERS

    yield "| name | function |\n|---|---|"
    for name, address in PERCEIVERS.items():
        yield f"| [`{name}`]({name}.md) | `{address}` |"


def _strategies() -> Iterator[str]:
    """The strategies, and the domains that use each of them where nobody says otherwise."""
    from tamp.domains.catalog import load_domain
    from tamp.pipeline.strategies.named import STRATEGIES

    own: dict[str, list[str]] = {}
    for name in sorted(path.parent.name for path in (DOCS.parent / "domains").glob("*/__init__.py")):
        own.setdefault(load_domain(name).strategy, []).append(f"`{name}`")
    yield "| name | the choice of the domains |\n|---|---|"
    for name in STRATEGIES:
        yield f"| [`{name}`]({name.replace('-', '_')}.md) | {', '.join(own.get(name, ()))} |"


def _tuning(prefix: str = "") -> Iterator[str]:
    """The numbers that a user may change; those whose meaning begins with a prefix."""
    from tamp.pipeline.options.tuning import Tuning

    yield "| name | default | valid | meaning |\n|---|---|---|---|"
    for field in dataclasses.fields(Tuning):
        low, high, text = (field.metadata[key] for key in ("low", "high", "help"))
        if text.startswith(prefix):
            default = field.default
            told = ",".join(f"{n:g}" for n in default) if isinstance(default, tuple) else f"{default:g}"
            yield f"| `{field.name}` | {told} | {low:g} to {high:g} | {text.removeprefix(f'{prefix}: ')} |"


PARTS = {
    "public names": _public_names,
    "commands": _commands,
    "task fields": _task_fields,
    "result fields": _result_fields,
    "scenarios": _scenarios,
    "tabletop pddl": _tabletop_pddl,
    "robot file": _robot_file,
    "robot": _robot,
    "simulators": _simulators,
    "perceivers": _perceivers,
    "strategies": _strategies,
    "tuning": _tuning,
}
"""What a part is called -> what makes its lines; words that follow the name are its arguments."""


def _part(name: str) -> Iterator[str]:
    """The lines of a part: that with the longest name that its own begins with."""
    known = max((part for part in PARTS if f"{name} ".startswith(f"{part} ")), key=len)
    return PARTS[known](*name.removeprefix(known).split())


def pages() -> Iterator[Path]:
    """The manual's pages."""
    yield from sorted(DOCS.rglob("*.md"))


if __name__ == "__main__":
    for page in pages():
        page.write_text(refreshed(page.read_text(encoding="utf-8")), encoding="utf-8")
