"""Carrying out in a simulator, before they are taken, those parts of a plan in which something falls.

Falls are planned without the hand: what it holds up, or takes along, as it draws back is seen only here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from tamp.execution.executor import execute
from tamp.execution.monitor import Monitor
from tamp.pipeline.prepare import Setup
from tamp.pipeline.strategies.serialization.plan_state import after
from tamp.task import Action, Fall, Grip, Plan, Release
from tamp.world.robot.model import RobotModel

LENIENT = Monitor(0.03, 0.5, 0.05, 1.0)  # what ends no farther off is corrected once it lies there


def rehearsal(setup: Setup, plan: Plan) -> str | None:
    """What goes astray in the simulator that settles scenes; None where nothing does.

    How long an execution may take does not count: a plan that is never carried out has no such limit.
    """
    for part in with_falls(setup.world.robot, plan):
        run = execute(setup.task, part, monitor=LENIENT, simulator=setup.settings.settling)
        if run.status == "deviated":
            return f"rehearsed: {run.deviation}"
    return None


def with_falls(robot: RobotModel, plan: Plan) -> Iterator[Plan]:
    """The parts of a plan in which something falls, each as short as it can be: its hand is empty at both ends.

    Each begins where the plan says that what comes before it ends.
    """
    done = 0
    for errand in _errands(plan.actions):
        if any(isinstance(step, Fall) for action in errand for step in action.steps):
            yield replace(after(robot, replace(plan, actions=plan.actions[:done])), actions=errand)
        done += len(errand)


def _errands(actions: tuple[Action, ...]) -> Iterator[tuple[Action, ...]]:
    """The actions of a plan, in groups after each of which the hand holds nothing."""
    errand: list[Action] = []
    held = False
    for action in actions:
        errand.append(action)
        for step in action.steps:
            held = isinstance(step, Grip) or (held and not isinstance(step, Release))
        if not held:
            yield tuple(errand)
            errand = []
    if errand:
        yield tuple(errand)
