"""One task: graphs drawn, laid out, settled and measured until one is of the level asked for."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tamp.errors import TaskError
from tamp.generate.draw import draw_goal, draw_start, draw_wanted
from tamp.generate.features import Features, in_each_others_way, matrices, measure
from tamp.generate.graph import SceneGraph, read_patterns
from tamp.generate.layout import lay_out
from tamp.generate.levels import Level, level
from tamp.generate.placement.object_model import Thing
from tamp.generate.scene import Scene, settled_scene
from tamp.scenarios.library.model import SETS, Model
from tamp.task import At, Task

VERSION = 2
"""Of the generator: the same version, seed and library give the same tasks."""
ATTEMPTS = 400
"""Choices of objects before a task is given up."""
STARTS, GOALS = 3, 6
"""Layouts tried for one choice of objects."""


@dataclass(frozen=True)
class Recipe:
    """Which task of which run.

    Attributes:
        seed: of the run.
        set: "trial" or "contest".
        index: its number in its set, from 1.
        level: 1 to 5.
        family: one of the families of scene graphs.
    """

    seed: int
    set: str
    index: int
    level: int
    family: str

    @property
    def name(self) -> str:
        """What the task and its file are called."""
        return f"{self.set}_{self.index:04d}"

    @property
    def comment(self) -> str:
        """What the first line of the task's file says of it."""
        how = f"{self.set} task {self.index}, level {self.level}, family {self.family}"
        return f"# Made by `tamp generate` (generator {VERSION}, seed {self.seed}): {how}.\n"


@dataclass(frozen=True, eq=False)
class Made:
    """A task and how it came about.

    Attributes:
        recipe: what was asked for.
        task: the task.
        features: what was measured.
        start, goal: its scene graphs.
        rejected: reason -> how many layouts were rejected for it.
    """

    recipe: Recipe
    task: Task
    features: Features
    start: SceneGraph
    goal: SceneGraph
    rejected: Counter[str]

    @property
    def comment(self) -> str:
        """What the task's file says of itself."""
        return f"{self.recipe.comment}# Start: {self.start}\n# Goal: {self.goal}\n"


def make_task(recipe: Recipe, library: Sequence[Model]) -> Made:
    """Make the task of a recipe; the same for the same recipe and library, whatever else is made.

    Raises:
        TaskError: where no choice of objects leads to one, as with a library that lacks what the family needs.
    """
    models = [model for model in library if model.set == SETS[0] or recipe.set != SETS[0]]
    patterns = read_patterns()[recipe.family]
    rejected: Counter[str] = Counter()
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng((recipe.seed, SETS.index(recipe.set), recipe.index, attempt))
        things, graph = draw_goal(patterns, models, level(recipe.level), rng)
        if not _wanted_choice(things, recipe):
            rejected["objects"] += 1
            continue
        found = _scenes(things, graph, level(recipe.level), rng, rejected)
        if found is not None:
            start, goal, features = found
            return Made(recipe, _task(recipe, things, start, goal), features, start.graph, goal.graph, rejected)
    reasons = ", ".join(f"{reason} {count}" for reason, count in rejected.most_common())
    raise TaskError(f"no {recipe.family} task of level {recipe.level} in {ATTEMPTS} attempts; rejected for: {reasons}")


def _wanted_choice(things: dict[str, Thing], recipe: Recipe) -> bool:
    """Enough objects, and in the contest some of both sets."""
    low, high = level(recipe.level).objects
    sets = {item.model.set for item in things.values()}
    return low <= len(things) <= high and (recipe.set == SETS[0] or sets == set(SETS))


def _scenes(
    things: dict[str, Thing], graph: SceneGraph, of: Level, rng: np.random.Generator, rejected: Counter[str]
) -> tuple[Scene, Scene, Features] | None:
    """A start, a goal, and what they measure; None where no layout of these objects is of the level."""
    for _ in range(STARTS):
        start = _start(things, graph, of, rng, rejected)
        if start is None:
            continue
        for _ in range(GOALS):
            goal, reason = _goal(things, graph, start, of, rng)
            if goal is None:
                rejected[reason] += 1
                continue
            features = measure(things, start, goal)
            if features.fit(of):
                return start, goal, features
            rejected["level"] += 1
    return None


def _start(
    things: dict[str, Thing], goal: SceneGraph, of: Level, rng: np.random.Generator, rejected: Counter[str]
) -> Scene | None:
    graph = draw_start(things, goal, of, rng)
    layout = lay_out(graph, things, rng)
    scene, reason = settled_scene(graph, things, layout) if layout is not None else (None, "no room")
    if scene is None:
        rejected[reason] += 1
    return scene


def _goal(
    things: dict[str, Thing], graph: SceneGraph, start: Scene, of: Level, rng: np.random.Generator
) -> tuple[Scene | None, str]:
    """A goal scene, or None and why not."""
    clear_of = matrices(start.poses) if of.cycles[1] == 0 else {}
    layout = lay_out(graph, things, rng, wanted=draw_wanted(start, graph, of, rng), clear_of=clear_of)
    if layout is None:
        return None, "no room"
    if not in_each_others_way(things, start, layout, of):
        return None, "level"
    return settled_scene(graph, things, layout)


def _task(recipe: Recipe, things: dict[str, Thing], start: Scene, goal: Scene) -> Task:
    objects = [
        replace(item.object(name, start.poses[name]), goal=At(goal.poses[name]))
        for name, item in sorted(things.items())
    ]
    return Task(recipe.name, tuple(objects), level=recipe.level)
