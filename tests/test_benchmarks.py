"""Every benchmark can be started: it finds what it measures."""

from importlib import import_module
from pathlib import Path

import pytest

COMMANDS = sorted(path for path in Path(__file__).parents[1].glob("benchmarks/*.py") if path.stem != "__init__")


@pytest.mark.parametrize("path", COMMANDS, ids=lambda path: path.stem)
def test_each_module_there_is_a_command(path):
    import_module(f"benchmarks.{path.stem}")
    assert 'if __name__ == "__main__":' in path.read_text(encoding="utf-8")
