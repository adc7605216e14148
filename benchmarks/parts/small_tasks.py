"""Many different tasks that are planned in about a second each: the small members of the families, and scenarios."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, cycle, islice

import tamp
from tamp.scenarios.families import FAMILIES
from tamp.task import Task

MEMBERS = (
    ("sort", 1), ("clutter", 2), ("stack", 2), ("clutter", 1), ("permutation", 2), ("sort", 2), ("clutter", 3),
    ("stack", 3), ("sort", 3), ("permutation", 3),
)  # fmt: skip
SCENARIOS = ("one_object", "stand_up_can", "mug_onto_tray", "in_box", "build_tower", "occupied_goal", "on_region")
"""With meshes, cylinders, containers, towers."""


def small_tasks(number: int) -> list[Task]:
    """So many tasks, no two alike: scenarios and members of families in turn, with one seed after the other."""
    scenarios = (tamp.load_task(f"scenarios/{name}.yaml") for name in SCENARIOS)
    members = _members()
    mixed = chain.from_iterable((task, *islice(members, 4)) for task in scenarios)
    return list(islice(chain(mixed, members), number))


def _members() -> Iterator[Task]:
    for index, (family, n) in enumerate(cycle(MEMBERS)):
        yield FAMILIES[family](n, index // len(MEMBERS))
