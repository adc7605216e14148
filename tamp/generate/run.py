"""A set of tasks in a folder: which ones, the files they are written to, and a line about each."""

from __future__ import annotations

import json
import shutil
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict
from filecmp import cmp
from pathlib import Path
from typing import Any

from tamp.errors import TampError, meant
from tamp.generate.graph import read_patterns
from tamp.generate.levels import LEVELS
from tamp.generate.task import Made, Recipe, make_task
from tamp.scenarios.library.model import FILE, SETS, read_library
from tamp.task.files.save import save_task

TRIAL_SHARE = 1100 / 1400
"""Of all tasks, as the paper has it."""
OBJECTS = "objects"
"""The folder of the meshes, beside the tasks."""


def recipes(n: int, seed: int, level: int | None = None, family: str | None = None) -> list[Recipe]:
    """What tasks there shall be: trial and contest in the paper's proportion, levels and families in turn.

    Args:
        n: how many in all.
        seed: of the run.
        level: only this level.
        family: only this family.

    Raises:
        TampError: for a level or family that does not exist.
    """
    families, numbers = list(read_patterns()), [of.number for of in LEVELS]
    if level is not None and level not in numbers:
        raise TampError(f"there is no level {level}; valid are {', '.join(map(str, numbers))}")
    if family is not None and family not in families:
        raise TampError(f"there is no family {family!r}; {meant(family, families)}valid are {', '.join(families)}")
    numbers, families = [level] if level else numbers, [family] if family else families
    trial = round(n * TRIAL_SHARE)
    return [
        Recipe(seed, name, i + 1, numbers[i % len(numbers)], families[i // len(numbers) % len(families)])
        for name, count in zip(SETS, (trial, n - trial), strict=True)
        for i in range(count)
    ]


def copy_library(source: Path, output: Path) -> None:
    """Copy a library beside the tasks that refer to it, once for all.

    Raises:
        TaskError: where the library is not valid.
        TampError: where it cannot be written, or would be written over another one, which tasks may refer to.
    """
    models = read_library(source)
    folder = output / OBJECTS
    files = [source / FILE, *(model.shape.path for model in models)]
    copies = {path: folder / path.resolve().relative_to(source.resolve()) for path in files}
    try:
        if others := [copy for path, copy in copies.items() if copy.exists() and not cmp(path, copy, shallow=False)]:
            raise TampError(f"{others[0]} is of another library, and is not replaced; choose another --output")
        for path, copy in copies.items():
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, copy)
    except OSError as error:
        raise TampError(f"{output}: cannot be written: {error.strerror}") from error


def refuse_to_overwrite(folder: Path, wanted: Sequence[Recipe]) -> None:
    """Refuse a folder where a file would be written over another; the same task may be made again.

    Raises:
        TampError: names the first such file.
    """
    _refuse_to_shorten(folder / "tasks.json", {recipe.name for recipe in wanted})
    for path, recipe in ((folder / f"{recipe.name}.yaml", recipe) for recipe in wanted):
        begins = recipe.comment.encode()
        if path.exists() and not (path.is_file() and path.read_bytes().startswith(begins)):
            raise TampError(f"{path} is there already and is another task; choose another --output")


def _refuse_to_shorten(listed: Path, wanted: Collection[str]) -> None:
    """Refuse to write a list of tasks over one that has others, whose files would stay without a line."""
    if not listed.is_file():
        return
    try:
        names = [row["name"] for row in json.loads(listed.read_bytes())]
    except (ValueError, TypeError, KeyError):
        raise TampError(f"{listed} is there already and is no list of tasks; choose another --output") from None
    if others := [name for name in names if name not in wanted]:
        raise TampError(
            f"{listed} lists {len(names)} tasks, of which {len(others)} would not be made again, such as {others[0]}; "
            f"ask for them too, or choose another --output"
        )


def make_tasks(output: str, asked: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Make tasks and write their files: the work of one worker, with JSON-like values in and out.

    Args:
        output: the folder, which has the library already.
        asked: the recipes.

    Returns:
        {"rows": [...]}: recipe, features and rejections of each task.
    """
    folder = Path(output).resolve()
    library = read_library(folder / OBJECTS)
    rows = []
    for fields in asked:
        made = make_task(Recipe(**fields), library)
        write_task(made, folder)
        rows.append({"name": made.task.name, **fields, **asdict(made.features), "rejected": dict(made.rejected)})
    return {"rows": rows}


def write_task(made: Made, folder: Path) -> Path:
    """Write a task's file, which says in its first lines how it was made."""
    path = folder / f"{made.task.name}.yaml"
    save_task(made.task, path)
    path.write_text(made.comment + path.read_text(encoding="utf-8"), encoding="utf-8")
    return path
