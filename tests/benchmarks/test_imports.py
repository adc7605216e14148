"""What benchmarks import of this program is there, also where they import it only once they run."""

from __future__ import annotations

import ast
import importlib
import importlib.util
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "benchmarks"


@pytest.mark.parametrize("path", sorted(FOLDER.rglob("*.py")), ids=lambda path: str(path.relative_to(FOLDER)))
def test_what_is_imported_is_there(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom) or (node.module or "").partition(".")[0] != "tamp":
            continue
        try:
            module = importlib.import_module(str(node.module))
        except ModuleNotFoundError as error:
            if (error.name or "").partition(".")[0] == "tamp":
                raise
            continue  # an extra is not installed
        for name in node.names:
            below = hasattr(module, "__path__") and importlib.util.find_spec(f"{node.module}.{name.name}") is not None
            assert below or hasattr(module, name.name), f"line {node.lineno}: {node.module} has no {name.name}"
