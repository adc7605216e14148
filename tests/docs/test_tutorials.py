"""The tutorials are notebooks; their cells run from top to bottom, and print what the notebook says they print."""

from __future__ import annotations

import importlib.util
import io
import re
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import pytest

from tests.docs.manual import ROOT, TUTORIALS, cells

NEEDS = {"perception": "embreex", "contest": "embreex"}
"""Tutorial -> the library of its extra."""

WRITTEN = ("buttons", "my_eyes")
"""Packages that tutorials write."""


def printed(cell: dict[str, Any]) -> str:
    """What a cell has printed, as its notebook has it."""
    return "".join("".join(out["text"]) for out in cell["outputs"] if out["output_type"] == "stream")


def without_numbers(text: str) -> str:
    """A text in which times and lengths play no role."""
    return re.sub(r"\d+(\.\d+)?", "#", text)


def test_tutorials_are_found() -> None:
    names = {"first_plan", "own_sampler", "own_skill", "own_robot", "perception", "contest"}
    assert {path.stem for path in TUTORIALS} >= names


@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_does_what_it_shows(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = NEEDS.get(path.stem)
    if library is not None and importlib.util.find_spec(library) is None:
        pytest.skip(f"the extra {path.stem!r} is missing: {library}")
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    namespace: dict[str, Any] = {"__name__": path.stem}
    try:
        for cell in cells(path):
            said = io.StringIO()
            with redirect_stdout(said):
                exec("".join(cell["source"]), namespace)
            assert without_numbers(said.getvalue()) == without_numbers(printed(cell))
    finally:
        for name in [name for name in sys.modules if name.partition(".")[0] in WRITTEN]:
            del sys.modules[name]


@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_was_run_in_order(path: Path) -> None:
    assert [cell["execution_count"] for cell in cells(path)] == list(range(1, len(cells(path)) + 1))
    assert not [out for cell in cells(path) for out in cell["outputs"] if out["output_type"] == "error"]
