from __future__ import annotations

import pytest

from tamp.generate.task import Made, Recipe, make_task
from tamp.scenarios.library.model import read_library

ASKED = [
    (1, "food"),
    (2, "tableware"),
    (3, "stationery"),
    (4, "mixed"),
    (5, "food"),
    (2, "stationery"),
    (5, "tableware"),
]


@pytest.fixture(scope="session")
def made() -> list[Made]:
    """Tasks of every level and family, of both sets."""
    library = read_library()
    recipes = [Recipe(1, "contest" if i % 2 else "trial", i + 1, *asked) for i, asked in enumerate(ASKED)]
    return [make_task(recipe, library) for recipe in recipes]
