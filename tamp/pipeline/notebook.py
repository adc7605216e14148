"""The way in for whoever calls samplers, collision checks, kinematics or motion planning by hand, as in a notebook."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from tamp.clock import now
from tamp.execution.simulators import DEFAULT
from tamp.pipeline.options.settings import Settings
from tamp.pipeline.options.trust import refuse_code
from tamp.pipeline.options.tuning import DEFAULT_TUNING, Tuning
from tamp.pipeline.prepare import prepare as set_up
from tamp.planning import Context
from tamp.planning.context import generator_for
from tamp.streams.workspace import Workspace
from tamp.task import Task
from tamp.task.expected import expect_task


def prepare(
    task: Task,
    *,
    timeout: float = math.inf,
    domain: str | None = None,
    simulator: str = DEFAULT,
    tuning: Tuning | Mapping[str, Any] = DEFAULT_TUNING,
    trust_task_code: bool = False,
) -> Workspace:
    """The workspace that samplers see: the settled start, what the goals mean, and the world with its robot.

    `workspace.world.checker(scene)` checks collisions, `tamp.world.kinematics.inverse.inverse` solves inverse
    kinematics for `workspace.world.robot`, `tamp.world.motion.planner.plan_motion` plans motions.

    Args:
        task: the task.
        timeout: for settling [s].
        domain: what it is planned with, in place of the task's own.
        simulator: in which scenes settle.
        tuning: numbers that a user may change: a `Tuning`, or a mapping of some of its fields.
        trust_task_code: import the domain that the task's file names where it is not an installed one.

    Raises:
        PlanningFailure: where settling has not ended in time.
        DomainError, RobotError, TaskError: where the input cannot be used.
    """
    expect_task(task)
    refuse_code(task, domain, trusted=trust_task_code)
    deadline = now() + timeout
    settings = Settings(
        domain=domain, settling=simulator, tuning=tuning if isinstance(tuning, Tuning) else Tuning.of(tuning)
    )
    setup = set_up(task, deadline, settings)
    return setup.observe(setup.start, deadline)


def sampler_context(
    workspace: Workspace,
    *,
    seed: int = 0,
    fluents: Iterable[tuple[object, ...]] | None = None,
    timeout: float = math.inf,
) -> Context:
    """What a sampler takes first, to call it by hand: `next(sample_grasp(tamp.sampler_context(workspace), "red"))`.

    Args:
        workspace: from `prepare`.
        seed: of its random generator.
        fluents: for a stream with `:fluents`, the facts that hold, such as ("AtPose", "red", placement); None is where
            everything stands at the start.
        timeout: how long the sampler may take [s].
    """
    standing = tuple(("AtPose", name, place) for name, place in workspace.start.items())
    facts = standing if fluents is None else tuple(fluents)
    return Context(workspace, lambda: generator_for(seed, "notebook", ()), now() + timeout, facts, seed)
