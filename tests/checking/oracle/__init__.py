"""A slow judge of plans by brute force: Pinocchio's kinematics, every 10 ms, points in half-spaces. No cleverness.

It shares nothing with the checker but the reading of meshes. It calls wrong only what is clearly wrong, well beyond the
checker's tolerances: the checker must reject all that it calls wrong. A start, or a motion, that it has looked at among
the same bodies it does not look at again, so that of many mutants of one plan only what was changed costs time.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from tamp.task import Box, Fall, Grip, Move, Plan, Pose, Release, Step, Task
from tests.checking.oracle.bearing import gives_in
from tests.checking.oracle.bodies import body_of, tool_at
from tests.checking.oracle.bookkeeping import bookkeeping
from tests.checking.oracle.carrying import jerked_out
from tests.checking.oracle.falls import FALLEN, TOPPLED, fall, gave_way
from tests.checking.oracle.leaning import leaning
from tests.checking.oracle.letting_down import lets_down
from tests.checking.oracle.lying import lies_down
from tests.checking.oracle.overhanging import tips_off
from tests.checking.oracle.pushes import push
from tests.checking.oracle.rocking import rocking
from tests.checking.oracle.rolling import rolled, rolling, spreading
from tests.checking.oracle.stacks import toppling
from tests.checking.oracle.striking import staying
from tests.checking.oracle.tilting import tipping
from tests.checking.oracle.topples import topple
from tests.checking.oracle.verges import beyond_rim
from tests.checking.oracle.world import (
    World,
    arrive,
    between,
    goals,
    grip,
    let_go,
    misnamed,
    rests,
    start,
    strains,
    sweep,
)

TAKEN = {"pick": True, "unstack": False}
PUT = {"place": True, "stack": False, "lay": True, "lay-on": False}
"""Whether each action is about the table, or else about an object."""


@dataclass
class Oracle:
    """The judge, and what it found so far of motions and starts: by a hash of all that it looked at."""

    found: dict[bytes, str | None] = field(default_factory=dict)

    def wrong(self, task: Task, plan: Plan) -> str | None:
        """What is clearly wrong with a plan, or None."""
        bodies = {o.name: body_of(o.shape) for o in task.objects}
        bodies["table"] = body_of(Box((*task.table.size, task.table.thickness)))
        poses = {name: pose.matrix for name, pose in plan.start.items()}
        poses["table"] = Pose((*task.table.center, -task.table.thickness / 2)).matrix
        quick, slow = (World(task, bodies, dict(poses), np.array(plan.home)) for _ in range(2))
        slow.stays.update(staying(task, poses))
        return (
            bookkeeping(plan)
            or start(quick)
            or leaning(quick)
            or rolling(quick)
            or spreading(quick)
            or rolled(quick)
            or beyond_rim(quick)
            or self._tipping(quick)
            or self._replay(quick, plan, sweep=False)
            or goals(quick, plan)
            or self._replay(slow, plan, sweep=True)
        )

    def _replay(self, world: World, plan: Plan, sweep: bool) -> str | None:
        """Grips, releases, falls and pushes, and with `sweep` everything on the way."""
        for action in plan.actions:
            if not sweep and (text := toppling(world)) is not None:
                return f"before {action}: {text}"
            if not sweep and (text := misnamed(world, action, TAKEN)) is not None:
                return f"{action}: {text}"
            if sweep and action.name in TAKEN and (text := lets_down(world, action.arguments[0])) is not None:
                return f"{action}: {text}"
            for step in action.steps:
                text = self._swept(world, step) if sweep and isinstance(step, Move) else None
                if isinstance(step, Fall) and step.object not in action.arguments[:1]:
                    text = gave_way(world, step)
                else:
                    text = text or _carried_out(world, step, toppling=action.name == "topple")
                if text is not None:
                    return f"{action}: {text}"
            if not sweep and (text := misnamed(world, action, PUT)) is not None:
                return f"{action}: {text}"
            if action.name in ("place", "stack"):
                text = "the hand stays round the object" if _is_round(world, action.arguments[0]) else None
                text = text or rests(world, action.arguments[0])
                text = text or (lies_down(world, action.arguments[0]) if sweep else None)
                text = text or (gives_in(world, action.arguments[0]) if sweep else None)
                text = text or (tips_off(world, action.arguments[0]) if sweep else None)
                if text is not None:
                    return f"{action}: {text}"
            if sweep and action.name in ("place", "stack"):
                world.stays.update(rocking(world))
        return None if sweep else toppling(world) or beyond_rim(world)

    def _tipping(self, world: World) -> str | None:
        things = [(thing.name, thing.shape, thing.mass) for thing in world.task.objects]
        words = repr(("start", list(world.poses), things, world.task.table))
        return self._once(words, world.poses.values(), lambda: tipping(world))

    def _swept(self, world: World, move: Move) -> str | None:
        run = move.trajectory
        arrays = (run.times, run.positions, run.velocities, *world.poses.values(), *world.stays.values())
        shapes = [(thing.name, thing.shape) for thing in world.task.objects]
        told = (move.phase, move.opening, move.held, move.pushed)
        words = repr((*told, list(world.poses), list(world.stays), shapes, world.task.table))
        return self._once(words, arrays, lambda: sweep(world, move))

    def _once(self, words: str, arrays: Iterable[np.ndarray], look: Callable[[], str | None]) -> str | None:
        """What a look finds, which sees only what the words and arrays say; looked at once."""
        key = hashlib.sha256(words.encode() + b"".join(array.tobytes() for array in arrays)).digest()
        if key not in self.found:
            self.found[key] = look()
        return self.found[key]


def _carried_out(world: World, step: Step, toppling: bool) -> str | None:
    """Carry a step out; what is clearly wrong with it, or None."""
    if isinstance(step, Grip):
        return grip(world, step)
    if isinstance(step, Release):
        return let_go(world, step)
    if isinstance(step, Fall):
        return fall(world, step, TOPPLED if toppling else FALLEN)
    text = (topple if toppling else push)(world, step)
    arrive(world, step)
    text = text or jerked_out(world, step)
    if world.held is not None and text is None:
        name, T = world.held
        weight = np.array([0.0, 0.0, -9.81 * world.task.object(name).mass])
        middle = np.eye(4)
        given = world.task.object(name).inertia
        middle[:3, 3] = world.bodies[name].center if given is None else given.frame.xyz
        if strains(world.q, T @ middle, weight):
            return f"the arm does not bear the weight of {name}"
    return text


def _is_round(world: World, name: str) -> bool:
    return bool(len(between(world, name, tool_at(world.q))))


def wrong(task: Task, plan: Plan) -> str | None:
    """What is clearly wrong with one plan, or None."""
    return Oracle().wrong(task, plan)
