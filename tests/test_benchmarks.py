"""Every benchmark can be started: it finds what it measures."""

from importlib import import_module
from pathlib import Path

import pytest

MODULES = sorted(path.stem for path in Path(__file__).parents[1].glob("benchmarks/*.py"))


@pytest.mark.parametrize("name", MODULES)
def test_imports(name):
    import_module(f"benchmarks.{name}")
