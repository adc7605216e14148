"""Taking hold of objects and putting them down: timed steps and effects that several skills share."""

from __future__ import annotations

from collections.abc import Iterator

from tamp.domains.skill import SceneChange
from tamp.domains.timing import Timing, held
from tamp.planning import GroundAction
from tamp.streams.hand.firmness import firmer
from tamp.streams.values import Handling
from tamp.task import Action, Fall, Grip, Release, Step

PUT = {"lay": "place", "lay-on": "stack"}  # what laying is called where nothing falls


def take(timing: Timing, action: GroundAction) -> Action:
    """Approach the object, grip it, lift it."""
    handling: Handling = action.args[-1]
    below = timing.still_below(handling.object, handling.placement)
    return Action(action.name, (handling.object, *below), tuple(_take(timing, handling)))


def put_down(timing: Timing, action: GroundAction) -> Action:
    """Lower the object, let it go where it shall be or above, and draw back."""
    handling: Handling = action.args[-1]
    name = action.name if handling.fall else PUT.get(action.name, action.name)
    return Action(name, (handling.object, *handling.placement.on), tuple(_put_down(timing, handling)))


def take_effect(action: GroundAction) -> SceneChange:
    """The object is in the hand, the arm where the lift ends."""
    handling: Handling = action.args[-1]
    return SceneChange(action.args[-2], {handling.object: None})


def put_down_effect(action: GroundAction) -> SceneChange:
    """The object is at its placement, the arm where the approach to it begins."""
    handling: Handling = action.args[-1]
    return SceneChange(action.args[-3], {handling.object: handling.placement})


def _take(timing: Timing, handling: Handling) -> Iterator[Step]:
    grasped = held(handling.object, handling.grasp)
    yield timing.move("approach", handling.approach, handling.opening, touching=handling.object)
    force = firmer(timing.workspace, handling.object, handling.grasp, handling.placement.pose)
    yield Grip(grasped, handling.grasp.width, force)
    timing.put(handling.object, None)
    yield timing.move("lift", handling.lift, handling.grasp.width, grasped)


def _put_down(timing: Timing, handling: Handling) -> Iterator[Step]:
    grasped = held(handling.object, handling.grasp)
    yield timing.move("lower", handling.lift[::-1], handling.grasp.width, grasped)
    yield Release(handling.object, handling.let_go, handling.opening)
    timing.put(handling.object, handling.let_go.matrix)
    if handling.dropped:
        yield _fall(timing, handling)
    yield timing.move("retreat", handling.approach[::-1], handling.opening, touching=handling.object)
    if handling.laid:
        yield _fall(timing, handling)


def _fall(timing: Timing, handling: Handling) -> Fall:
    timing.put(handling.object, handling.placement.pose.matrix)
    return Fall(handling.object, handling.placement.pose)
