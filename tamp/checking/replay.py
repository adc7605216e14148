"""Replay of a plan action by action: preconditions before, steps, effects after."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tamp.checking.falling import check_fall
from tamp.checking.grasp import between_pads
from tamp.checking.handling import check_grip, check_release
from tamp.checking.motion import check_move
from tamp.checking.nudging import check_nudge
from tamp.checking.pushing import check_push
from tamp.checking.scene import TABLE, Scene, State
from tamp.checking.standing import carriers, without_part
from tamp.checking.toppling import check_topple
from tamp.checking.transforms import inverse
from tamp.checking.verdict import Problem
from tamp.task.plan import Fall, Grip, Move, Release

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.checking.tolerances import Tolerances
    from tamp.task.model import Region
    from tamp.task.plan import Action, Plan

PICKS = ("pick", "unstack")
PLACES = ("place", "stack")
LAYS = ("lay", "lay-on")
NUDGE = "nudge"
TOPPLE = "topple"
SLIDES = ("slide", TOPPLE, NUDGE)
JUDGES = {TOPPLE: check_topple, NUDGE: check_nudge}


class Replay:
    """A plan being replayed: the state so far and the problems found."""

    def __init__(self, scene: Scene, plan: Plan, allow: Tolerances) -> None:
        self.scene = scene
        self.plan = plan
        self.allow = allow
        self.problems: list[Problem] = []
        poses = {name: plan.start[name].matrix for name in sorted(plan.start)}
        self.state = State(poses, np.array(plan.home, dtype=np.float64))
        self._index: int | None = None
        self._name = "start"

    def run(self) -> None:
        """Replay all actions."""
        for index, action in enumerate(self.plan.actions):
            self._index, self._name = index, str(action)
            if self._check_form(action):
                self._carry_out(action)
        self._index, self._name = None, "goal"

    def report(
        self, kind: str, sentence: str, bodies: tuple[str, ...] = (), depth: float = 0.0, after: float = 0.0
    ) -> None:
        """Note a problem of the present action, `after` seconds into the present step."""
        time = self.state.time + after
        self.problems.append(Problem(self._index, self._name, time, kind, bodies, depth, sentence))

    def _carry_out(self, action: Action) -> None:
        self._check_before(action)
        falling = {step.object for step in action.steps if isinstance(step, Fall)}
        for step in action.steps:
            if isinstance(step, Move) and step.pushed is not None:
                judge = JUDGES.get(action.name, check_push)
                judge(self.scene, self.state, step, step.pushed, self.allow, self.report)
            elif isinstance(step, Move):
                check_move(self.scene, self.state, step, self.allow, self.report)
            elif isinstance(step, Grip):
                check_grip(self.scene, self.state, step, self.allow, self.report)
            elif isinstance(step, Fall):
                toppled = action.name == TOPPLE
                check_fall(self.scene, self.state, step, self.allow, self.report, toppled=toppled)
            else:
                falls = step.object in falling
                check_release(self.scene, self.state, step, self.allow, self.report, falls=falls)
        self._check_after(action)

    def _check_form(self, action: Action) -> bool:
        """Whether the action's steps are those of an action of its name, about objects that there are."""
        grips = [step.attachment.object for step in action.steps if isinstance(step, Grip)]
        releases = [step.object for step in action.steps if isinstance(step, Release)]
        falls = [step.object for step in action.steps if isinstance(step, Fall)]
        pushes = [step.pushed.object for step in action.steps if isinstance(step, Move) and step.pushed is not None]
        about = action.arguments[0] if action.arguments else None
        expected: dict[str, tuple[list[str | None], ...]] = {
            **dict.fromkeys(PICKS, ([about], [], [], [])),
            **dict.fromkeys(PLACES, ([], [about], [], [])),
            **dict.fromkeys(LAYS, ([], [about], [about], [])),
            **dict.fromkeys(SLIDES, ([], [], [], [about])),
            TOPPLE: ([], [], [about], [about]),
            "move": ([], [], [], []),
        }
        known = {*self.state.poses, TABLE, *(region.name for region in self.scene.task.regions)}
        strangers = [name for name in action.arguments if name not in known]
        moved = [name for name in (*grips, *releases, *falls, *pushes) if name not in self.state.poses]
        if action.name not in expected:
            self.report("precondition", f"unknown action {action.name!r}; valid are {', '.join(sorted(expected))}")
        elif (grips, releases, falls, pushes) != expected[action.name]:
            done = zip(("grip", "release", "drop", "push"), (grips, releases, falls, pushes), strict=True)
            wrong = ", ".join(f"{verb} {what or 'nothing'}" for verb, what in done)
            self.report("precondition", f"its steps {wrong}")
        if strangers or moved:
            self.report("precondition", f"the task knows no {', '.join((*strangers, *moved))}")
        return not strangers and not moved

    def _check_before(self, action: Action) -> None:
        if not action.arguments or action.arguments[0] not in self.state.poses:
            return
        name, held = action.arguments[0], self.state.held
        if action.name in (*PICKS, *SLIDES) and held is not None:
            self.report("precondition", f"needs an empty hand, which holds {held.object}", (name, held.object))
        elif action.name in (*PLACES, *LAYS, "move") and (held is None or held.object != name):
            self.report("precondition", f"needs {name} in the hand, which holds {held.object if held else 'nothing'}")
        if action.name not in (*PICKS, *SLIDES) or held is not None:
            return
        under = carriers(self.scene, self.state, name, self.allow).bodies
        if action.name == "pick" and under and TABLE not in under:
            self.report("precondition", f"{name} stands on {', '.join(under)}, not on the table", (name, *under))
        self._check_on(name, action.arguments[1:])

    def _check_after(self, action: Action) -> None:
        about = action.arguments[0] if action.arguments else None
        if action.name in (*PLACES, *LAYS) and self.state.held is None and about in self.state.poses:
            self._check_on(action.arguments[0], action.arguments[1:])
            self._check_clear(action.arguments[0])

    def _check_on(self, name: str, targets: tuple[str, ...]) -> None:
        """The object stands or leans on, or is in, each of the bodies and regions that the action names."""
        regions = {region.name: region for region in self.scene.task.regions}
        for target in (target for target in targets if target in regions):
            if not in_region(self.scene, self.state, name, regions[target]):
                self.report("precondition", f"{name} is not in region {target}", (name,))
        touching = carriers(self.scene, self.state, name, self.allow)
        for target in without_part(touching, [target for target in targets if target not in regions]):
            self.report("precondition", f"{name} does not stand on {target}", (name, target))

    def _check_clear(self, name: str) -> None:
        """After letting go, the gripper has left: the object is no longer between the pads."""
        T_world_tool = self.scene.links.tree.tool(self.state.q[None])[0]
        T_tool_object = inverse(T_world_tool) @ self.state.poses[name]
        gripper = self.scene.links.tree.spec.gripper
        if between_pads(self.scene.solids[name], T_tool_object, gripper, gripper.stroke) is not None:
            self.report("release", f"the gripper does not retreat from {name}", (name,))


def in_region(scene: Scene, state: State, name: str, region: Region) -> bool:
    """Whether the centre of an object's footprint lies in a region of the table."""
    x, y = footprint_center(scene, state.poses[name], name)
    return abs(x - region.center[0]) <= region.size[0] / 2 and abs(y - region.center[1]) <= region.size[1] / 2


def footprint_center(scene: Scene, T: NDArray[np.float64], name: str) -> tuple[float, float]:
    """Centre of the box round an object's vertices as seen from above."""
    points = scene.solids[name].hull.part.vertices @ T[:3, :3].T + T[:3, 3]
    x, y, _ = (points.min(axis=0) + points.max(axis=0)) / 2
    return float(x), float(y)


def sorted_by_time(problems: list[Problem]) -> tuple[Problem, ...]:
    """Problems in the order in which they happen."""
    return tuple(sorted((replace(p) for p in problems), key=lambda p: p.time))
