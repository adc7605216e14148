"""The manual as tests read it: its pages' blocks of code and commands, and the cells of its notebooks."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
PAGES = (README, *sorted((ROOT / "docs").rglob("*.md")))
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.ipynb"))


def named(page: Path) -> str:
    """A page, as a test's name says it."""
    return page.relative_to(ROOT).with_suffix("").as_posix()


def blocks(page: Path, language: str) -> list[tuple[str, str]]:
    """(title, text) of each fenced block of a language; the title is empty where it has none."""
    text = page.read_text(encoding="utf-8")
    return re.findall(rf'^```{language}(?: title="(.*?)")?\n(.*?)^```', text, re.MULTILINE | re.DOTALL)


def files(page: Path, language: str) -> dict[str, str]:
    """The blocks of a language that are files, by their names."""
    return {title: text for title, text in blocks(page, language) if title}


def commands(page: Path) -> list[list[str]]:
    """The arguments of each `tamp` command in a page's sh blocks."""
    lines = [line for _, text in blocks(page, "sh") for line in text.splitlines()]
    return [shlex.split(line, comments=True)[1:] for line in lines if line.startswith("tamp ")]


def cells(notebook: Path) -> list[dict[str, Any]]:
    """The code cells of a notebook."""
    read = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return [cell for cell in read if cell["cell_type"] == "code"]
