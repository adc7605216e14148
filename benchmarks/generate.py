"""The task generator: time a task, what it rejects, whether scenes stay put and within reach, and what is solved.

Ten tasks of each level are solved with the time limits they come with; --quick makes fewer tasks and solves none.
"""

from __future__ import annotations

import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.harness import Row, main
from benchmarks.jobs import solve_all
from tamp.execution.settling import settle
from tamp.generate.graph import read_patterns
from tamp.generate.levels import LEVELS
from tamp.generate.reach import reachable
from tamp.generate.run import OBJECTS, copy_library, write_task
from tamp.generate.task import Made, Recipe, make_task
from tamp.generate.thing import Thing, thing
from tamp.scenarios.library.model import FOLDER, Model, read_library
from tamp.task import At, Object, Pose
from tamp.task.load import load_task


def rows(quick: bool) -> Iterator[Row]:
    """One row for each level."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copy_library(FOLDER, folder)
        library = read_library(folder / OBJECTS)
        make_task(Recipe(0, "trial", 0, 1, "mixed"), library)  # whatever is loaded once
        for level in LEVELS:
            yield _level(level.number, 4 if quick else 20, 0 if quick else 10, folder, library)


def _level(level: int, count: int, solving: int, folder: Path, library: Sequence[Model]) -> Row:
    families = list(read_patterns())
    recipes = [Recipe(0, "trial", 1000 * level + i, level, families[i % len(families)]) for i in range(count)]
    start = time.process_time()
    made = [make_task(recipe, library) for recipe in recipes]
    seconds = time.process_time() - start
    files = [write_task(one, folder) for one in made]
    rejected = sum((one.rejected for one in made), Counter[str]())
    row: Row = {
        "level": level,
        "tasks": count,
        "cpu_s_each": seconds / count,
        "objects": sum(one.features.objects for one in made) / count,
        "drift_max_mm": 1000 * max(_drift(file) for file in files),
        "in_reach": f"{sum(_in_reach(one, library) for one in made)} of {count}",
        "rejected": ", ".join(f"{reason} {number}" for reason, number in rejected.most_common()),
    }
    if solving:
        results = list(solve_all(files[:solving], seeds=[0]))
        solved = sum(result.status == "solved" for result in results)
        errors = [result.ede_m for result in results if result.ede_m is not None]
        row |= {"solved": f"{solved} of {solving}", "ede_cm": 100 * sum(errors) / len(errors)}
    return row


def _drift(file: Path) -> float:
    """How far anything in the scenes of a file moves when settled [m]."""
    task = load_task(file)
    scenes = ({o.name: o.pose for o in task.objects}, {o.name: _goal(o) for o in task.objects})
    return max(max(settle(task, poses).moved.values()) for poses in scenes)


def _in_reach(made: Made, library: Sequence[Model]) -> bool:
    things: dict[object, Thing] = {model.shape: thing(model) for model in library}
    return all(reachable(things[o.shape], pose.matrix) for o in made.task.objects for pose in (o.pose, _goal(o)))


def _goal(item: Object) -> Pose:
    assert isinstance(item.goal, At)
    return item.goal.pose


if __name__ == "__main__":
    main("generate", lambda quick: list(rows(quick)))
