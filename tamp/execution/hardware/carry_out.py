"""A plan carried out by a controller, step by step, and stopped at the first thing that is not as planned."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tamp.errors import PlanError
from tamp.execution.hardware.controller import Controller, ControllerError
from tamp.execution.simulator import GRAVITY
from tamp.task import Action, Fall, Grip, Move, Object, Plan, Release, Task, task_robot
from tamp.task.robot import GENTLE_FORCE

START_TOLERANCE = 0.05
"""How far the arm may stand from where a plan starts [rad]."""

OPENED = 0.0005
"""Fingers that are no farther from an opening than this are there [m]."""

FALL_S = 2.0
"""What a thing that was let go tilted is given to fall flat [s]."""


@dataclass(frozen=True)
class Outcome:
    """How far a plan was carried out.

    Attributes:
        done: how many actions were carried out whole.
        stopped: what stopped the plan; empty where nothing did.
    """

    done: int
    stopped: str = ""


def carry_out(
    task: Task, plan: Plan, controller: Controller, tell: Callable[[Action], None] = lambda action: None
) -> Outcome:
    """Let a controller carry a plan out.

    A grip that holds nothing and a hand that has lost what it held stop the plan where they are seen: after each step.
    Whether the plan is a right one is asked before, of the checker.

    Args:
        task: what the plan is for.
        plan: what is to be done.
        controller: of a robot that stands where the plan starts.
        tell: called with each action that is done.

    Raises:
        PlanError: where the plan is about other objects, or starts from another configuration; nothing has moved.
    """
    objects = {item.name: item for item in task.objects}
    _refuse_misfit(plan, objects, controller)
    hand = _Hand(controller, objects, task)
    for number, action in enumerate(plan.actions):
        try:
            for step in action.steps:
                hand.perform(step)
        except ControllerError as error:
            return Outcome(number, f"{action}: {error}")
        tell(action)
    return Outcome(len(plan.actions))


def _refuse_misfit(plan: Plan, objects: dict[str, Object], controller: Controller) -> None:
    unknown = sorted(plan.start.keys() - objects.keys())
    if unknown:
        raise PlanError(f"the plan is about {unknown[0]!r}; the task has {', '.join(sorted(objects))}")
    measured = np.array(controller.configuration())
    if len(measured) != len(plan.home):
        raise PlanError(f"the plan is for {len(plan.home)} joints; the controller tells {len(measured)}")
    off = float(np.abs(np.array(plan.home) - measured).max())
    if not off <= START_TOLERANCE:
        raise PlanError(f"the plan starts {off:.3f} rad from where the arm stands; {START_TOLERANCE} is tolerated")


class _Hand:
    """Passes steps on to a controller, and knows whether something should be held."""

    def __init__(self, controller: Controller, objects: dict[str, Object], task: Task) -> None:
        self._controller, self._objects = controller, objects
        self._gripper = task_robot(task).gripper
        self._held, self._forces = "", (GENTLE_FORCE, GENTLE_FORCE)

    def perform(self, step: Move | Grip | Release | Fall) -> None:
        """One step; ControllerError where it could not be done, or what should be held is not."""
        if isinstance(step, Move):
            if not self._held and abs(self._controller.opening() - step.opening) > OPENED:
                self._controller.open_to(step.opening)
            self._controller.follow(step.trajectory, step.opening)
        elif isinstance(step, Grip):
            self._held = step.attachment.object
            item = self._objects[self._held]
            self._forces = self._gripper.pressing(item.mass * GRAVITY, item.friction, step.force)
            gentle, firm = self._forces
            self._controller.grip(gentle)
            if firm > gentle:
                self._controller.grip(firm)
        elif isinstance(step, Release):
            gentle, firm = self._forces
            if self._held and firm > gentle:
                self._controller.grip(gentle)
            self._held = ""
            self._controller.open_to(step.opening)
        else:
            self._controller.wait(FALL_S)
        if self._held and not self._controller.holds():
            raise ControllerError(f"the hand does not hold {self._held}")
