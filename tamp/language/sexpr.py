"""S-expressions that remember where they stand: text -> nested nodes, with a limit on size and nesting.

A domain may lie in several files, one a skill: they are read as one text, and errors name the file that they stand in.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from tamp.errors import DomainError

if TYPE_CHECKING:
    from collections.abc import Iterable

MAX_DEPTH = 100
"""Deepest nesting of brackets; keeps every recursion over formulas far from Python's limit."""

MAX_SIZE = 10_000_000
"""Longest text [characters]."""

_TOKEN = re.compile(r";[^\n]*|[()]|[^\s();]+")


@dataclass(frozen=True, slots=True)
class Symbol:
    """A word, in lower case as PDDL ignores case; `position` is its offset in the text."""

    text: str
    position: int


@dataclass(frozen=True, slots=True)
class Leaf:
    """A Python value in a goal that was given as nested tuples."""

    value: object
    position: int


@dataclass(frozen=True, slots=True)
class Group:
    """A bracketed list of nodes; `position` is that of its opening bracket."""

    items: tuple[Node, ...]
    position: int


Node = Symbol | Leaf | Group


class Source(Protocol):
    """What knows how to say where a node stands."""

    def error(self, node: Node, message: str) -> DomainError:
        """The error to raise about a node."""
        ...


@dataclass(frozen=True, slots=True)
class Text:
    """PDDL text and the name it goes by in messages.

    Attributes:
        name: of the file.
        text: all of it.
        others: where further files begin in the text, and their names, where it was put together from several.
    """

    name: str
    text: str
    others: tuple[tuple[int, str], ...] = ()

    def error(self, node: Node, message: str) -> DomainError:
        """The error to raise about a node: `name:line:column: message`."""
        return self.error_at(node.position, message)

    def error_at(self, position: int, message: str) -> DomainError:
        """The error to raise about an offset in the text."""
        start, name = max(part for part in self.parts if part[0] <= position)
        line = self.text.count("\n", start, position) + 1
        column = position - max(start - 1, self.text.rfind("\n", start, position))
        return DomainError(f"{name}:{line}:{column}: {message}")

    @property
    def parts(self) -> tuple[tuple[int, str], ...]:
        """Where each file begins in the text, and its name."""
        return ((0, self.name), *self.others)


PDDL = str | Path | Sequence[str | Path]
"""PDDL text, the file it lies in, or several of either that are read as one."""


def load(text_or_path: PDDL, name: str) -> Text:
    """Take PDDL text as it is, or read the file of that name; text is what contains a bracket.

    Args:
        text_or_path: PDDL, or where it lies; of several, the sections of all.
        name: what text without a file is called in messages.

    Raises:
        DomainError: where there is no such file, it is not text, or it is too large.
    """
    if isinstance(text_or_path, str) and not text_or_path.strip():
        raise DomainError(f"the {name} text is empty: expected PDDL, or where a file of it lies")
    if isinstance(text_or_path, str) and ("(" in text_or_path or "\n" in text_or_path):
        source = Text(name, text_or_path)
    elif isinstance(text_or_path, str | Path):
        try:
            source = Text(str(text_or_path), Path(text_or_path).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise DomainError(f"cannot read the {name} file {str(text_or_path)[:200]!r}: {error}") from error
    elif isinstance(text_or_path, Sequence) and text_or_path:
        source = _joined([load(one, name) for one in text_or_path])
    else:
        found = "nothing" if text_or_path == () else type(text_or_path).__name__
        raise DomainError(f"the {name} must be PDDL text, a path, or a list of those, not {found}")
    if len(source.text) > MAX_SIZE:
        raise DomainError(f"{source.name}: {len(source.text)} characters; at most {MAX_SIZE} are read")
    return source


def _joined(texts: Sequence[Text]) -> Text:
    """Several texts as one; each begins on a line of its own."""
    starts = list(accumulate((len(text.text) + 1 for text in texts), initial=0))
    others = tuple((start, text.name) for start, text in zip(starts[1:-1], texts[1:], strict=True))
    return Text(texts[0].name, "\n".join(text.text for text in texts), others)


def read(source: Text) -> Group:
    """The one bracketed expression of a text; of several files, that of the first with what the others have to add.

    Raises:
        DomainError: for unbalanced brackets, text outside of them, or nesting deeper than MAX_DEPTH.
    """
    ends = [start for start, _ in source.others] + [len(source.text)]
    first, *others = (_read(source, start, end) for (start, _), end in zip(source.parts, ends, strict=True))
    for other in others:
        if _kind(other) != _kind(first):
            raise source.error(
                other, f"expected (define ...) of the same kind as in {source.name}, found {show(other)}"
            )
    return Group((*first.items, *(item for other in others for item in other.items[2:])), first.position)


def _kind(whole: Group) -> tuple[str, ...]:
    """("define", "domain") of `(define (domain NAME) ...)`."""
    match whole.items:
        case (Symbol(define), Group((Symbol(kind), _)), *_):
            return define, kind
    return ()


def _read(source: Text, start: int, end: int) -> Group:
    """The one bracketed expression between two places of a text."""
    stack: list[tuple[int, list[Node]]] = []
    whole: Group | None = None
    for match in _TOKEN.finditer(source.text, start, end):
        token, position = match.group(), match.start()
        if token.startswith(";"):
            continue
        if whole is not None:
            raise source.error_at(position, f"expected the end of the text, found {token[:40]!r}")
        if token == "(":
            if len(stack) >= MAX_DEPTH:
                raise source.error_at(position, f"brackets are nested deeper than {MAX_DEPTH} levels")
            stack.append((position, []))
        elif not stack:
            raise source.error_at(position, f"expected '(define', found {token[:40]!r}")
        elif token == ")":
            opened, items = stack.pop()
            group = Group(tuple(items), opened)
            if stack:
                stack[-1][1].append(group)
            else:
                whole = group
        else:
            stack[-1][1].append(Symbol(token.lower(), position))
    if stack:
        raise source.error_at(stack[-1][0], "this bracket is never closed")
    if whole is None:
        raise source.error_at(start, "expected '(define ...)', found nothing")
    return whole


def show(node: Node) -> str:
    """A node as text, cut to a readable length."""
    if isinstance(node, Symbol):
        return repr(node.text[:40])
    if isinstance(node, Leaf):
        return repr(node.value)[:60]
    if node.items and isinstance(node.items[0], Symbol):
        return f"'({node.items[0].text[:40]}{' ...' if len(node.items) > 1 else ''})'"
    return "'( ... )'" if node.items else "'()'"


def suggest(word: str, valid: Iterable[str], what: str) -> str:
    """The end of a message about an unknown name: close matches, or all valid names where they are few."""
    names = sorted(valid)
    close = get_close_matches(word[:100], names, n=3, cutoff=0.6)
    if close:
        return f"; did you mean {' or '.join(map(repr, close))}?"
    if not names:
        return f"; there are no {what}"
    return f"; the {what} are: {', '.join(names[:20])}{', ...' if len(names) > 20 else ''}"
