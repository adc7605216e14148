"""Hostile inputs: valid files with bytes, words and values changed, and plain noise. The same seed, the same input."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Sequence
from random import Random
from typing import Any

NUMBERS = (
    "0", "-1", "1e999", "-1e308", "1e-320", "nan", ".inf", "NaN", "1" * 400, "0x1F", "1_000", "--1", "1.2.3", "-0.0",
    "2147483648", "99999999999999999999",
)  # fmt: skip
SCRAPS = (
    "", "\0", "\ufeff", "\t", "\r", "&a [*a, *a]", "*b", "!!python/object:os.system", "<<: *x", "? ", "%YAML 9", "---",
    "{" * 60, "[" * 5000, "(" * 5000, "(and " * 300, ")", '"', "'", "|", ";", "#", "\u2028", "\ud7ff",
    "../../etc/passwd", "/dev/zero",
    "/dev/stdin", "f 1 2 3\n", "f 99 98 97\n", "f 1 1 1\n", "f -1 -2 -3\n", "v 0 0 0\n", "o\n", "(:action",
    "(forall (?x) ", "(not ", "?x", "- object", ":derived", "(either a b)",
)  # fmt: skip
VALUES: tuple[Any, ...] = (
    None, True, "", "x" * 1000, [], {}, [[]], [None] * 3, {"a": {}}, 0, -1, 1e308, 1e-308, 10**400, -0.0, 0.5, "table",
    "robot", [0, 0, 0, 0], [1e200] * 7, "nan",
)  # fmt: skip
WORD = re.compile(r"[\w.+:?/-]+|\s+|.", re.DOTALL)
NAME = re.compile(r"[\w.+:?/-]+")
NUMBER = re.compile(r"-?\d+(\.\d+)?([eE][-+]?\d+)?")


def hostile_text(seeds: Sequence[str], random: Random) -> bytes:
    """One of the seeds after a few changes of its text; now and then noise."""
    if random.random() < 0.05:
        return random.randbytes(random.choice((0, 1, 10, 1000, 100_000)))
    text = random.choice(seeds)
    for _ in range(random.choice((1, 1, 1, 1, 2, 3, 8, 30))):
        text = random.choice(CHANGES)(text, seeds, random)
    data = text.encode("utf-8", errors="surrogatepass")
    return _flipped(data, random) if random.random() < 0.15 else data


def hostile_json(seeds: Sequence[str], random: Random) -> bytes:
    """A JSON seed with values replaced, removed and repeated anywhere in its tree; sometimes its text changed too."""
    tree = json.loads(random.choice(seeds))
    for _ in range(random.choice((1, 1, 2, 4, 10))):
        _change_tree(tree, random)
    text = json.dumps(tree)
    return hostile_text([text], random) if random.random() < 0.2 else text.encode()


def _change_tree(tree: Any, random: Random) -> None:
    """Walk down to a random depth and change one entry of what is there."""
    node = tree
    while True:
        if not isinstance(node, dict | list) or not node:
            return
        key = random.choice(sorted(node)) if isinstance(node, dict) else random.randrange(len(node))
        if isinstance(node[key], dict | list) and node[key] and random.random() < 0.85:
            node = node[key]
            continue
        break
    what = random.randrange(5)
    if what == 0:
        del node[key]
    elif what == 1 and isinstance(node, list):
        node.insert(key, copy.deepcopy(node[key]))
    elif what == 2 and isinstance(node, dict):
        node[random.choice(("extra", "object", "pose", ""))] = node[key]
    elif what == 3 and isinstance(node[key], float):
        node[key] *= random.choice((-1, 0, 1.01, 2, 1e9, 1e-9, 1e300))
    else:
        node[key] = copy.deepcopy(random.choice(VALUES))


def _flipped(data: bytes, random: Random) -> bytes:
    changed = bytearray(data)
    for _ in range(random.choice((1, 5, 50)) if changed else 0):
        changed[random.randrange(len(changed))] = random.randrange(256)
    return bytes(changed)


def _span(text: str, random: Random) -> tuple[int, int]:
    start = random.randrange(len(text) + 1)
    return start, min(len(text), start + random.randrange(random.choice((4, 40, 400))))


def _delete(text: str, seeds: Sequence[str], random: Random) -> str:
    start, end = _span(text, random)
    return text[:start] + text[end:]


def _repeat(text: str, seeds: Sequence[str], random: Random) -> str:
    start, end = _span(text, random)
    return text[:end] + text[start:end] * random.choice((1, 2, 50, 2000)) + text[end:]


def _splice(text: str, seeds: Sequence[str], random: Random) -> str:
    other = random.choice(seeds)
    (start, end), (a, b) = _span(text, random), _span(other, random)
    return text[:start] + other[a:b] + text[end:]


def _insert(text: str, seeds: Sequence[str], random: Random) -> str:
    at = random.randrange(len(text) + 1)
    return text[:at] + random.choice(SCRAPS) + text[at:]


def _other_number(text: str, seeds: Sequence[str], random: Random) -> str:
    found = list(NUMBER.finditer(text))
    if not found:
        return text
    match = random.choice(found)
    return text[: match.start()] + random.choice(NUMBERS) + text[match.end() :]


def _swap_words(text: str, seeds: Sequence[str], random: Random) -> str:
    words = WORD.findall(text)
    if len(words) < 2:
        return text
    i, j = random.randrange(len(words)), random.randrange(len(words))
    words[i], words[j] = words[j], words[i]
    return "".join(words)


def _copy_word(text: str, seeds: Sequence[str], random: Random) -> str:
    """One word in place of another of its kind: a number for a number, a name for a name."""
    words, others = WORD.findall(text), WORD.findall(random.choice(seeds))
    if words and others:
        i = random.randrange(len(words))
        alike = [word for word in others if NAME.fullmatch(word) and NAME.fullmatch(words[i])]
        words[i] = random.choice(alike or others)
    return "".join(words)


def _drop_word(text: str, seeds: Sequence[str], random: Random) -> str:
    words = WORD.findall(text)
    if words:
        del words[random.randrange(len(words))]
    return "".join(words)


def _truncate(text: str, seeds: Sequence[str], random: Random) -> str:
    return text[: random.randrange(len(text) + 1)]


CHANGES = (
    _delete, _repeat, _splice, _insert, _insert, _other_number, _other_number, _swap_words, _swap_words,
    _copy_word, _copy_word, _copy_word, _copy_word, _drop_word, _drop_word, _truncate,
)  # fmt: skip
