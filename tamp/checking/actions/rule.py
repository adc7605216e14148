"""What a rule is: the checker's word on one kind of action; and what most rules ask of an action's steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from tamp.checking.actions.arm_motion import check_move, sensible
from tamp.checking.actions.fall import check_fall
from tamp.checking.actions.grip_and_release import check_grip, check_release, check_unsqueezed
from tamp.checking.physics.support import carriers, without_part
from tamp.checking.scene import TABLE, in_region
from tamp.task.plan import Fall, Grip, Move, Release

if TYPE_CHECKING:
    from collections.abc import Callable

    from tamp.checking.actions.arm_motion import Report
    from tamp.checking.replay import Replay
    from tamp.checking.scene import Scene, State
    from tamp.checking.tolerances import Tolerances
    from tamp.task.plan import Action, Attachment, Step

    PushCheck = Callable[[Scene, State, Move, Attachment, Tolerances, Report], None]


class ActionRule(Protocol):
    """The rule of one kind of action, found by the action's name."""

    def check(self, replay: Replay, action: Action) -> None:
        """Report what is wrong with an action, and leave `replay.state` as the action leaves the world.

        Args:
            replay: the state that the action begins in; `replay.report` takes what is wrong.
            action: its name, arguments and steps, but for falls at its end of objects other than its first argument:
                those have given way, and are judged apart.
        """


def has_steps(replay: Replay, action: Action, *verbs: str) -> bool:
    """Whether an action can be carried out; reports steps that are not those of its kind, and unknown names.

    Args:
        replay: where to report.
        action: the action.
        verbs: what its steps do to its first argument, in order, besides moving the arm: "grip", "release", "drop",
            "push".

    Returns:
        False where it is about something that the task does not know.
    """
    about = action.arguments[0] if action.arguments else None
    done = [(verb, name) for step in action.steps for verb, name in _deeds(step)]
    if done != [(verb, about) for verb in verbs]:
        did = [*done, *((verb, "nothing") for verb in verbs if verb not in dict(done))]
        wanted = ", ".join(f"{verb} {about}" for verb in verbs) or "only move the arm"
        replay.report("precondition", f"its steps {', '.join(map(' '.join, did))}; those of this action {wanted}")
    objects = replay.state.poses.keys()
    places = {TABLE, *(region.name for region in replay.scene.task.regions)}
    strangers = [name for name in action.arguments if name not in objects and name not in places]
    strangers += [name for _, name in done if name not in objects and name not in strangers]
    if strangers:
        replay.report("precondition", f"the task knows no {', '.join(strangers)}")
    return not strangers


def named_apart(replay: Replay, action: Action, verb: str, before: tuple[str, ...], after: tuple[str, ...]) -> None:
    """Report motions named as those of the other side of what an action does, which is its first step of `verb`.

    Who carries out a plan goes by these names: what draws back is done though the object is lost, all else is left out.
    """
    expected = before
    for step in action.steps:
        if any(done == verb for done, _ in _deeds(step)):
            expected = after
        elif isinstance(step, Move) and step.phase not in expected:
            wanted = " or ".join(expected)
            replay.report("continuity", f"a {step.phase} motion where this action has {wanted} ones")


def _deeds(step: Step) -> list[tuple[str, str]]:
    if isinstance(step, Grip):
        return [("grip", step.attachment.object)]
    if isinstance(step, Release):
        return [("release", step.object)]
    if isinstance(step, Fall):
        return [("drop", step.object)]
    return [] if step.pushed is None else [("push", step.pushed.object)]


def carry_out(replay: Replay, step: Step, *, push: PushCheck | None = None, falls: str = "", touched: str = "") -> None:
    """Judge one step and bring the state to its end.

    Args:
        replay: the state that the step begins in.
        step: the step.
        push: judges a motion that pushes something; without it no motion may.
        falls: name of an object that falls as soon as it is let go or pushed over; "" where none does.
        touched: name of an object that the hand may touch without holding it, such as a button; "" where there is none.
    """
    scene, state, allow, report = replay.scene, replay.state, replay.allow, replay.report
    if isinstance(step, Move) and step.pushed is not None and push is not None:
        push(scene, state, step, step.pushed, allow, report)
    elif isinstance(step, Move):
        if state.held is None and step.held is None:
            check_unsqueezed(scene, state, step.opening, allow, report)
        check_move(scene, state, sensible(scene, state, step, touched, allow), allow, report)
    elif isinstance(step, Grip):
        check_grip(scene, state, step, allow, report)
    elif isinstance(step, Fall):
        check_fall(scene, state, step, allow, report, toppled=push is not None)
    else:
        check_release(scene, state, step, allow, report, falls=step.object == falls)


def needs_empty_hand(replay: Replay, action: Action) -> bool:
    """Whether the hand is empty; reports where it is not."""
    held = replay.state.held
    if held is not None:
        bodies = (*action.arguments[:1], held.object)
        replay.report("precondition", f"needs an empty hand, which holds {held.object}", bodies)
    return held is None


def needs_in_hand(replay: Replay, name: str) -> None:
    """Report where the hand does not hold an object."""
    held = replay.state.held
    if held is None or held.object != name:
        replay.report("precondition", f"needs {name} in the hand, which holds {held.object if held else 'nothing'}")


def stands_on(replay: Replay, name: str, targets: tuple[str, ...]) -> None:
    """Report each body and region, of those that an action names, that an object is not on, in, or leaning on."""
    scene, state = replay.scene, replay.state
    if name not in state.poses:
        replay.report("precondition", f"{name} is no object", (name,))
        return
    regions = {region.name: region for region in scene.task.regions}
    for target in (target for target in targets if target in regions):
        if not in_region(scene, state, name, regions[target]):
            replay.report("precondition", f"{name} is not in region {target}", (name,))
    touching = carriers(scene, state, name, replay.allow)
    for target in without_part(touching, [target for target in targets if target not in regions]):
        replay.report("precondition", f"{name} does not stand on {target}", (name, target))
