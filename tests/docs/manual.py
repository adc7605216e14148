"""The manual as tests read it: its pages' blocks of code and commands, and the cells of its notebooks."""

from __future__ import annotations

import ast
import json
import re
import shlex
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

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


def write_files_of(tutorial: str, folder: Path) -> None:
    """Let the cells of a tutorial that write files do so in a folder, which is made."""
    folder.mkdir(parents=True)
    with pytest.MonkeyPatch.context() as there:
        there.chdir(folder)
        there.setattr(sys, "path", list(sys.path))
        namespace: dict[str, object] = {}
        for cell in cells(ROOT / "docs" / "tutorials" / f"{tutorial}.ipynb"):
            source = "".join(cell["source"])
            if "mkdir(" in source or "write_text(" in source:
                exec(source.partition("judgement =")[0], namespace)


def undocumented(file: Path) -> set[str]:
    """What a Python file imports of tamp, and attributes that it asks for, of which the manual says nothing."""
    manual = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    nodes = list(ast.walk(ast.parse(file.read_text(encoding="utf-8"))))
    imports = [node for node in nodes if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tamp")]
    assert not any(
        name.name.startswith("tamp.") for node in nodes if isinstance(node, ast.Import) for name in node.names
    )
    used = {str(node.module) for node in imports} | {name.name for node in imports for name in node.names}
    others = {"np", "math"}
    known = {word for kind in (np.ndarray, np.random.Generator, str, dict, list, set, Path) for word in dir(kind)}
    for node in nodes:
        if isinstance(node, ast.Attribute) and not others & {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}:
            used |= {node.attr} - known
    return {word for word in used if not re.search(rf"\b{re.escape(word)}\b", manual)}
