"""From a symbolic solution to a plan that a robot can run: every handling and path timed and checked, in order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from tamp.streams.collisions import CONTACT_DEPTH
from tamp.streams.values import ArmPath, Configuration, Grasp, Handling, Slide
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Action, Attachment, Fall, Grip, Move, Release, Step
from tamp.world.scene import Scene
from tamp.world.timing import time_free_path

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

CARRYING = 0.5  # share of the limits while holding an object: friction alone keeps it from turning in the fingers
GENTLE = 0.4  # share of the limits near an object
PUT = {"lay": "place", "lay-on": "stack"}  # what laying is called where nothing falls
PUSHING = 0.2  # share of the limits while pushing one: it must not slide on where the hand slows down
CLEARANCE = 0.0005  # least distance along the timed curve; the path under it kept more [m]


class NotFree(Exception):  # noqa: N818  an outcome of timing, for the caller to plan again
    """A timed motion cannot keep clear, however closely it follows its path."""


def assemble(workspace: Workspace, solution: Sequence[Any]) -> tuple[Action, ...]:
    """Turn ground actions of the tabletop domain into timed actions.

    Args:
        workspace: where they happen, objects at their start.
        solution: the planner's ground actions, each with `name` and `args`.

    Raises:
        NotFree: where a timed motion touches something.
    """
    assembly = _Assembly(workspace)
    return tuple(assembly.action(ground.name, ground.args) for ground in solution)


class _Assembly:
    """Replays a solution; knows where everything stands when an action begins."""

    def __init__(self, workspace: Workspace) -> None:
        self._world = workspace.world
        self._poses = {name: placement.pose.matrix for name, placement in workspace.start.items()}

    def action(self, name: str, args: Sequence[Any]) -> Action:
        """The timed action; the replay goes on to the state after it."""
        match name:
            case "move-free":
                start, goal, path = args
                return Action("move", (), (self._transit(start, goal, path),))
            case "move-holding":
                obj, grasp, _, _, path = args
                return Action("move", (obj,), (self._transfer(obj, grasp, path),))
            case "pick" | "unstack":
                handling: Handling = args[-1]
                return Action(name, (handling.object, *handling.placement.on), tuple(self._pick(handling)))
            case "place" | "stack" | "lay" | "lay-on":
                handling = args[-1]
                name = name if handling.fall else PUT.get(name, name)
                return Action(name, (handling.object, *handling.placement.on), tuple(self._place(handling)))
            case "slide" | "topple" | "nudge":
                slide: Slide = args[-1]
                return Action(name, (slide.object, *slide.end.on), tuple(self._slide(slide)))
        raise ValueError(f"the tabletop domain has no action {name!r}")

    def _transit(self, start: Configuration, goal: Configuration, path: ArmPath) -> Move:
        return self._move("transit", path.points, min(start.opening, goal.opening))

    def _transfer(self, obj: str, grasp: Grasp, path: ArmPath) -> Move:
        return self._move("transfer", path.points, grasp.width, _held(obj, grasp))

    def _pick(self, handling: Handling) -> Iterator[Step]:
        held = _held(handling.object, handling.grasp)
        yield self._move("approach", handling.approach, handling.opening, touching=handling.object)
        yield Grip(held, handling.grasp.width)
        del self._poses[handling.object]
        yield self._move("lift", handling.lift, handling.grasp.width, held)

    def _place(self, handling: Handling) -> Iterator[Step]:
        held = _held(handling.object, handling.grasp)
        yield self._move("lower", handling.lift[::-1], handling.grasp.width, held)
        yield Release(handling.object, handling.let_go, handling.opening)
        self._poses[handling.object] = handling.let_go.matrix
        if handling.dropped:
            yield self._fall(handling)
        yield self._move("retreat", handling.approach[::-1], handling.opening, touching=handling.object)
        if handling.fall and not handling.dropped:
            yield self._fall(handling)

    def _fall(self, handling: Handling) -> Fall:
        self._poses[handling.object] = handling.placement.pose.matrix
        return Fall(handling.object, handling.placement.pose)

    def _slide(self, slide: Slide) -> Iterator[Step]:
        yield self._move("approach", slide.approach, slide.opening, touching=slide.object)
        yield self._push(slide)
        self._poses[slide.object] = slide.end.pose.matrix
        if slide.fall:
            yield Fall(slide.object, slide.end.pose)
        yield self._move("retreat", slide.retreat, slide.opening, touching=slide.object)

    def _push(self, slide: Slide) -> Move:
        pushed = Attachment(slide.object, slide.T_tool_object)
        scene = Scene(self._poses).attached(slide.object, slide.T_tool_object.matrix, slide.opening)
        checker = self._world.checker(scene, margin=CLEARANCE, held_margin=-CONTACT_DEPTH - CLEARANCE)
        timed = time_free_path(slide.push, self._world.robot.spec, checker, speed=PUSHING)
        if timed.trajectory is None:
            raise NotFree(f"push: {timed.reason}")
        contacts = frozenset({("robot", slide.object), *((slide.object, below) for below in slide.start.on)})
        return Move("push", timed.trajectory, slide.opening, None, contacts, pushed)

    def _move(
        self,
        phase: str,
        path: NDArray[np.float64],
        opening: float,
        held: Attachment | None = None,
        touching: str | None = None,
    ) -> Move:
        near_support = phase in ("lift", "lower")
        scene = Scene(self._poses, opening=opening)
        if held is not None:
            scene = scene.attached(held.object, held.T_tool_object.matrix, opening)
        checker = self._world.checker(
            scene,
            margin=CLEARANCE,
            held_margin=-CONTACT_DEPTH - CLEARANCE if near_support else CLEARANCE,
            touch={} if touching is None else {touching: -2 * CLEARANCE},
        )
        speed = {"transit": 1.0, "transfer": CARRYING}.get(phase, GENTLE)
        timed = time_free_path(path, self._world.robot.spec, checker, speed=speed)
        if timed.trajectory is None:
            raise NotFree(f"{phase}: {timed.reason}")
        contacts = {("robot", touching)} if touching is not None else set()
        if near_support and held is not None:
            contacts |= {(held.object, other) for other in (TABLE, *self._poses)}
        return Move(phase, timed.trajectory, opening, held, frozenset(contacts))


def _held(obj: str, grasp: Grasp) -> Attachment:
    return Attachment(obj, grasp.T_object_tool.inverse())
