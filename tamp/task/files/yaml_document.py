"""YAML text -> plain values and the line of every field. Hostile until parsed: size, depth, aliases, tags bounded.

Scalars follow YAML 1.2 (`on`, `off`, `yes`, `no` are text, `1e-3` is a number), so `goal: {on: shelf}` is what it says.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from tamp.errors import TaskError, nearest
from tamp.task.files.regular_file import read_regular

FieldPath = tuple[str | int, ...]

MAX_BYTES = 1 << 18
MAX_DEPTH = 20
MAX_ALIASES = 100
MAX_VALUES = 50_000
TOO_DEEP = "maximum nesting depth"
"""What libyaml says, from 0.2.6 on, where brackets are nested deeper than it reads."""

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_INTEGER = re.compile(r"[-+]?[0-9]{1,300}")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_WORDS: Mapping[str, Any] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
    **{sign + word: float(sign + "inf") for sign in ("", "+", "-") for word in (".inf", ".Inf", ".INF")},
}


@dataclass(frozen=True)
class Document:
    """A parsed file.

    Attributes:
        name: how messages call the file.
        value: mappings as dict with text keys, sequences as tuple, scalars as str, int, float, bool or None.
        lines: line of each field, counted from 1.
    """

    name: str
    value: Any
    lines: Mapping[FieldPath, int]

    def line(self, field: FieldPath) -> int:
        """Line of `field`, or of its nearest ancestor in the file."""
        while field not in self.lines:
            field = field[:-1]
        return self.lines[field]

    def where(self, field: FieldPath) -> str:
        """`file:line: field`, the beginning of every message."""
        place = f"{self.name}:{self.line(field)}"
        return f"{place}: {dotted(field)}" if field else place


def dotted(field: FieldPath) -> str:
    """A field path as people write it: `objects[2].pose.xyz`."""
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in field).removeprefix(".")


def read_document(path: Path) -> Document:
    """Parse one YAML file.

    Raises:
        TaskError: where the file is missing, too large, not UTF-8, not YAML, or uses what a task file has no use for
            (explicit tags, several documents, non-text keys, duplicate keys, deep nesting, many aliases).
    """
    try:
        data = read_regular(path, MAX_BYTES)
    except IsADirectoryError:
        raise TaskError(f"{path}: cannot be read: it is a folder; name the files in it: {path / '*.yaml'}") from None
    except FileNotFoundError:
        if path.is_symlink():
            raise TaskError(f"{path}: cannot be read: it links to {path.readlink()}, which does not exist") from None
        beside = [each.name for each in path.parent.glob("*.y*ml")] if path.parent.is_dir() else []
        near = nearest(path.name, beside)
        hint = "" if near is None else f"; did you mean {path.with_name(near)}?"
        raise TaskError(f"{path}: cannot be read: there is no such file{hint}") from None
    except OSError as error:
        raise TaskError(f"{path}: cannot be read: {error.strerror or error}") from error
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise TaskError(f"{path}: not UTF-8 text (byte {error.start})") from error
    return parse_document(text, str(path))


def parse_document(text: str, name: str) -> Document:
    """Parse YAML text; `name` stands for the file in messages. Raises TaskError as `read_document` does."""
    try:
        _bound_events(text, name)
        root = yaml.compose(text, Loader=_LOADER)
    except yaml.MarkedYAMLError as error:
        line, said = error.problem_mark.line + 1 if error.problem_mark else 1, error.problem or error.context or ""
        if TOO_DEEP in said:
            raise TaskError(f"{name}:{line}: nested deeper than {MAX_DEPTH} levels") from error
        raise TaskError(f"{name}:{line}: not YAML: {said}") from error
    except yaml.YAMLError as error:
        raise TaskError(f"{name}: not YAML: {str(error).splitlines()[0]}") from error
    if root is None:
        return Document(name, None, {(): 1})
    lines: dict[FieldPath, int] = {}
    value = _Values(name, lines).value(root, ())
    return Document(name, value, lines)


def _bound_events(text: str, name: str) -> None:
    """Refuse what would make composing expensive, before anything is built."""
    depth = aliases = documents = 0
    for event in yaml.parse(text, Loader=_LOADER):
        line = _line(event)
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        aliases += isinstance(event, yaml.AliasEvent)
        documents += isinstance(event, yaml.DocumentStartEvent)
        if depth > MAX_DEPTH:
            raise TaskError(f"{name}:{line}: nested deeper than {MAX_DEPTH} levels")
        if aliases > MAX_ALIASES:
            raise TaskError(f"{name}:{line}: more than {MAX_ALIASES} aliases")
        if documents > 1:
            raise TaskError(f"{name}:{line}: a second YAML document; a task file has one")
        tag = getattr(event, "tag", None)
        if tag is not None:
            raise TaskError(f"{name}:{line}: the tag {tag!r} is not allowed; write plain values")


def _line(thing: yaml.Event | yaml.Node) -> int:
    return int(thing.start_mark.line) + 1 if thing.start_mark else 1


class _Values:
    """Turns composed nodes into values, noting the line of each field."""

    def __init__(self, name: str, lines: dict[FieldPath, int]) -> None:
        self._name = name
        self._lines = lines

    def value(self, node: yaml.Node, field: FieldPath) -> Any:
        line = _line(node)
        self._lines.setdefault(field, line)
        # Aliases may repeat a part of the file many times, or contain themselves: both end at a bound.
        if len(self._lines) > MAX_VALUES or len(field) > MAX_DEPTH:
            raise TaskError(f"{self._name}:{line}: its aliases expand to more than a task file may hold")
        if isinstance(node, yaml.SequenceNode):
            return tuple(self.value(item, (*field, index)) for index, item in enumerate(node.value))
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, field)
        return _scalar(node)

    def _mapping(self, node: yaml.MappingNode, field: FieldPath) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for key_node, value_node in node.value:
            line = _line(key_node)
            if not isinstance(key_node, yaml.ScalarNode):
                raise TaskError(f"{self._name}:{line}: a field's name must be text")
            key = key_node.value
            if key in result:
                raise TaskError(f"{self._name}:{line}: {dotted((*field, key))} stands twice; keep one")
            self._lines[(*field, key)] = line
            result[key] = self.value(value_node, (*field, key))
        return result


def _scalar(node: yaml.Node) -> Any:
    text: str = node.value
    if getattr(node, "style", None) in ("'", '"', "|", ">"):
        return text
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        return int(text)
    return float(text) if _FLOAT.fullmatch(text) else text
