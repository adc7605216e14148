"""Where samplers are tried: a task made ready, as the planning problem that a domain makes of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from tamp.conformance.pool import Pool
from tamp.domains.domain import Domain
from tamp.domains.samplers import resolve_samplers
from tamp.domains.skill import Question
from tamp.errors import SamplerError
from tamp.language import Stream
from tamp.pipeline.prepare import prepare
from tamp.planning import Problem
from tamp.streams.cache import SampleCache
from tamp.streams.values import Configuration
from tamp.streams.workspace import Workspace
from tamp.task import Task
from tamp.task.files.load import load_task

FIRST_TASKS = ("five_apart", "on_region", "in_box", "mug_onto_tray")
"""Built-in scenarios that together give inputs to most streams of the tabletop domain."""


@dataclass(frozen=True)
class Bench:
    """A problem, and inputs that a stream may be called with.

    Attributes:
        task: the task's name.
        problem: with the domain's own samplers.
        pool: facts of the problem and of what was sampled upstream.
        inputs: one tuple of values for each call.
    """

    task: str
    problem: Problem
    pool: Pool
    inputs: tuple[tuple[Any, ...], ...]

    def with_fresh_scene(self) -> Problem:
        """The same problem with nothing remembered from earlier calls."""
        scene: Workspace = self.problem.scene
        fresh = replace(scene, cache=SampleCache())
        problem = self.problem
        return Problem(problem.domain, problem.streams, problem.samplers, problem.init, problem.goal, fresh)


def set_up(domain: Domain, stream: Stream, tasks: Iterable[Task], seed: int, calls: int) -> Bench:
    """The first of the tasks that gives the stream inputs.

    Args:
        domain: the domain.
        stream: the stream to be called.
        tasks: in order of preference.
        seed: decides every random choice.
        calls: so many inputs at most.

    Raises:
        SamplerError: where no task gives the stream inputs.
    """
    names = []
    for task in tasks:
        names.append(task.name)
        for problem in _problems(domain, task):
            pool = Pool(problem, seed)
            pool.provide(stream)
            if inputs := pool.inputs(stream, calls):
                return Bench(task.name, problem, pool, tuple(inputs))
    conditions = ", ".join(f"({atom.predicate} ...)" for atom in stream.domain)
    raise SamplerError(
        f"no inputs for {stream.name} in {', '.join(names)}: nothing satisfies {conditions} there; "
        "give a task that has them with --task"
    )


def default_tasks() -> Iterator[Task]:
    """The built-in scenarios, read as they are needed."""
    folder = Path(str(files("tamp"))) / "scenarios"
    others = sorted(path.stem for path in folder.glob("*.yaml") if path.stem not in FIRST_TASKS)
    for name in (*FIRST_TASKS, *others):
        yield load_task(folder / f"{name}.yaml")


def _problems(domain: Domain, task: Task) -> Iterator[Problem]:
    setup = prepare(task)
    workspace = setup.observe(setup.start)
    spec = setup.world.robot.spec
    question = Question(Configuration(spec.home, spec.gripper.stroke), facts=task.init)
    yield from domain.problems(workspace, resolve_samplers(domain.samplers), question)
