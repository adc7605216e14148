"""Where samplers are tried: a task made ready, as the planning problem that a domain makes of it."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from tamp.conformance.sampler.calls import call
from tamp.conformance.sampler.pool import Pool, Values
from tamp.conformance.sampler.telling import telling
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

log = logging.getLogger("tamp")

FIRST_TASKS = ("five_apart", "on_region", "in_box", "mug_onto_tray")
"""Built-in scenarios that together give inputs to most streams of the tabletop domain."""

LOOKED_AT = 6
"""So many problems with inputs that tell little are looked at before the first of them has to do."""


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
        fresh = replace(scene, world=scene.world.with_nothing_answered(), cache=SampleCache())
        problem = self.problem
        return Problem(problem.domain, problem.streams, problem.samplers, problem.init, problem.goal, fresh)


def set_up(domain: Domain, stream: Stream, tasks: Iterable[Task] | None, seed: int, calls: int) -> Bench:
    """The first of the tasks that gives the stream inputs: if it can be, of all kinds, and with outputs to be had.

    Args:
        domain: the domain.
        stream: the stream to be called.
        tasks: in order of preference; the built-in scenarios where it is None.
        seed: decides every random choice.
        calls: so many inputs at most.

    Raises:
        SamplerError: where no task gives the stream inputs.
    """
    found: list[Bench] = []
    names = []
    for task in _default_tasks(domain) if tasks is None else tasks:
        names.append(task.name)
        log.info("looking for inputs of %s in %s", stream.name, task.name)
        for problem in _problems(domain, task):
            pool = Pool(problem, seed)
            pool.provide(stream)
            inputs, enough = telling(problem, stream, pool, calls)
            if inputs:
                found.append(Bench(task.name, problem, pool, tuple(inputs)))
                if enough and _has_outputs(problem, stream, inputs, seed):
                    return found[-1]
                if len(found) == LOOKED_AT:
                    return found[0]
    if found:
        return found[0]
    none = f"no inputs for {stream.name} in {', '.join(names)}"
    if tasks is None:
        none = f"no built-in scenario gives inputs for {stream.name}"
    conditions = ", ".join(f"({atom.predicate} ...)" for atom in stream.domain)
    raise SamplerError(f"{none}: nothing satisfies {conditions} there; give a task that has them with --task")


def _has_outputs(problem: Problem, stream: Stream, inputs: Iterable[Values], seed: int) -> bool:
    """Whether the domain's own sampler gives anything for some of the inputs."""
    return any(call(problem, stream, v, key=str(n), seed=seed, outputs=1).outputs for n, v in enumerate(inputs))


def _default_tasks(domain: Domain) -> Iterator[Task]:
    """The built-in scenarios, read as they are needed, but for those that ask for another domain than the tabletop."""
    folder = Path(str(files("tamp"))) / "scenarios"
    others = sorted(path.stem for path in folder.glob("*.yaml") if path.stem not in FIRST_TASKS)
    tasks = (load_task(folder / f"{name}.yaml") for name in (*FIRST_TASKS, *others))
    return (task for task in tasks if task.domain in ("tabletop", domain.name))


def _problems(domain: Domain, task: Task) -> Iterator[Problem]:
    setup = prepare(task)
    workspace = setup.observe(setup.start)
    spec = setup.world.robot.spec
    question = Question(Configuration(spec.home, spec.gripper.stroke), facts=task.init)
    yield from domain.problems(workspace, resolve_samplers(domain.samplers), question)
