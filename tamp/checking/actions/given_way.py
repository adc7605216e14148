"""Falls of what the hand does not move: a plan may say where objects come to that give way to what it does."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from tamp.task.plan import Fall

if TYPE_CHECKING:
    from tamp.checking.replay import Replay
    from tamp.task.plan import Action

SAME = 2e-4
"""Said to come so near to where an object comes to, it is said to come there [m]."""


def told_apart(action: Action) -> tuple[Action, tuple[Fall, ...]]:
    """An action by itself, and the falls at its end of other objects than the one that it is about."""
    own, steps = action.arguments[:1], action.steps
    count = len(steps)
    while count > 0 and isinstance(fall := steps[count - 1], Fall) and fall.object not in own:
        count -= 1
    falls = tuple(step for step in steps[count:] if isinstance(step, Fall))
    return (replace(action, steps=steps[:count]), falls) if falls else (action, ())


def check_given_way(replay: Replay, fall: Fall) -> None:
    """Judge the fall of an object that has given way; afterwards it is said to be where it is.

    Only what `State.came` names has, and it has come to no other place than `State.stayed` tells.
    """
    scene, state, name = replay.scene, replay.state, fall.object
    if name not in state.poses:
        replay.report("precondition", f"the task knows no {name}")
        return
    if name not in state.came:
        replay.report("fall", f"{name} is said to come to rest elsewhere, and nothing lets it", bodies=(name,))
        return
    there = state.stayed[name]
    off = scene.displacement(name, there, fall.pose.matrix)
    if off > SAME:
        sentence = f"{name} gives way, and comes to rest {1000 * off:.1f} mm from where it is said to"
        replay.report("fall", sentence, bodies=(name,), depth=off)
    state.poses[name] = there
    state.came.remove(name)
    del state.stayed[name]
