"""Collision-free motions between two configurations, empty-handed or holding, in the scene as it is by then."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp import clock
from tamp.streams.collisions import ARM_MARGIN
from tamp.streams.context import Context
from tamp.streams.hand.stability import hanging
from tamp.streams.motion.payload import load_aware
from tamp.streams.values import ArmPath, Configuration, Grasp
from tamp.streams.workspace import Workspace, standing
from tamp.task import Pose
from tamp.world.motion.paths import RESOLUTION, densify
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.motion.paths import Touching
    from tamp.world.motion.planner import KnownChecker, MotionResult
    from tamp.world.world import World

RECHECK = 0.01  # paths are rechecked this finely, so that little is lost of the margin in between [rad]
ITERATIONS = 3000  # a query that OMPL has not answered by then is given up for this state
ROOM = 0.01  # what is held keeps so far from all else where that is easy: it may slip in the fingers [m] ...
ENDS = 0.5  # ... but where the arm is so near to one end of its way: there it may stand closer [rad]
EASY = 300  # iterations in which that is found, or not sought any longer
PRESSED = 0.0008  # where the arm stands no deeper in something, it may still draw back [m]
SPARED = 0.0001  # of the distance at such a start, in which rounding may make a difference [m]


def plan_free_motion(context: Context, start: Configuration, goal: Configuration) -> Iterator[ArmPath]:
    """Yield a path of the empty-handed arm among the objects as they stand in `context.fluents`."""
    # The fingers close to the narrower opening before the motion and open to the other one after it.
    scene = Scene(poses=_poses(context), opening=min(start.opening, goal.opening))
    yield from _paths(
        context, scene, start, goal, kept_from(context.scene.world, scene, np.asarray(start.q), ARM_MARGIN)
    )


def kept_from(world: World, scene: Scene, start: NDArray[np.float64], margin: float) -> float:
    """How far the empty-handed arm keeps away from everything [m]: a margin, or less where it stands nearer already.

    An execution that stopped may leave it beside something, or against it; from there, too, it has to move on.
    """
    checker = world.checker(scene, margin=margin)
    if checker.free(start) or (distance := checker.distance(start)) < -PRESSED:
        return margin
    return distance - SPARED


class RoomyChecker:
    """A collision check in which what is held keeps farther away from all else than it must, but near the ends.

    Args:
        tight: the check of what must be kept clear.
        roomy: the same with more room.
        ends: where the way begins and where it ends, shape (dof,) each [rad].
    """

    def __init__(self, tight: KnownChecker, roomy: KnownChecker, ends: Sequence[NDArray[np.float64]]) -> None:
        self._tight, self._roomy, self._ends = tight, roomy, ends
        self.robot = tight.robot

    @property
    def fingerprint(self) -> bytes:
        """Equal for checkers that answer every question alike."""
        return self._tight.fingerprint + self._roomy.fingerprint + b"".join(q.tobytes() for q in self._ends)

    def free(self, q: NDArray[np.float64]) -> bool:
        """Whether a configuration, shape (dof,), is free."""
        return self._there(q).free(q)

    def edge_free(self, q0: NDArray[np.float64], q1: NDArray[np.float64], resolution: float = RESOLUTION) -> bool:
        """The same of all of a straight edge."""
        if self._roomy.edge_free(q0, q1, resolution):
            return True
        return all(map(self.free, densify(np.array([q0, q1]), resolution)))

    def contact(self, q: NDArray[np.float64]) -> Touching | None:
        """Two bodies in contact, or None where there are none."""
        return self._there(q).contact(q)

    def _there(self, q: NDArray[np.float64]) -> KnownChecker:
        near = any(float(np.linalg.norm(q - end)) < ENDS for end in self._ends)
        return self._tight if near else self._roomy


def plan_holding_motion(
    context: Context, obj: str, grasp: Grasp, start: Configuration, goal: Configuration
) -> Iterator[ArmPath]:
    """Yield a path of the arm holding `obj` among the objects as they stand in `context.fluents`.

    What turns in the fingers as it is lifted has room for that on its way, too, where this is easy.
    """
    poses = {name: T for name, T in _poses(context).items() if name != obj}
    T_tool_object = grasp.T_object_tool.inverse()
    scene = Scene(poses=poses).attached(obj, T_tool_object.matrix, grasp.width)
    world = context.scene.world
    for q, end in ((start, "start"), (goal, "goal")):
        if (stands := _standing_still(context, obj, grasp, scene, q)).bodies:
            _refuse(context, replace(stands, reason=stands.reason.replace("the start", f"the {end}", 1)))
            return
    lifted = Pose.from_matrix(world.robot.forward(np.asarray(start.q))) @ T_tool_object
    turned = hanging(context.scene, obj, grasp, lifted)
    if turned is not None and clock.now() < context.deadline:
        as_planned = world.checker(scene, margin=ARM_MARGIN)
        efforts = ((ROOM, EASY), (0.0, EASY))
        path = _path(context, scene.attached(obj, turned.matrix, grasp.width), start, goal, ARM_MARGIN, efforts).path
        if path is not None and as_planned.path_free(path, RECHECK):
            yield ArmPath(path)
            return
    yield from _paths(context, scene, start, goal, ARM_MARGIN, ((ROOM, EASY), (ARM_MARGIN, ITERATIONS)))


def _poses(context: Context) -> dict[str, Any]:
    placed = standing(context.fluents)
    return {name: placed[name].pose.matrix for name in sorted(placed)}


def _paths(
    context: Context,
    scene: Scene,
    start: Configuration,
    goal: Configuration,
    margin: float,
    efforts: Sequence[tuple[float, int]] = ((ARM_MARGIN, ITERATIONS),),
) -> Iterator[ArmPath]:
    """Yield the path of `_path`, or say why there is none; nothing after the deadline."""
    if clock.now() >= context.deadline:
        return
    result = _path(context, scene, start, goal, margin, efforts)
    if result.path is not None:
        yield ArmPath(result.path)
        return
    _refuse(context, result)


def _standing_still(context: Context, obj: str, grasp: Grasp, scene: Scene, q: Configuration) -> MotionResult:
    """The motion of no length at a configuration: why none begins or ends there is found out once for all of them."""
    others = tuple(sorted((name, place) for name, place in standing(context.fluents).items() if name != obj))
    workspace: Workspace = context.scene

    def found() -> MotionResult:
        checker = workspace.world.checker(scene, margin=ARM_MARGIN, held_margin=ARM_MARGIN)
        budget = max(context.deadline - clock.now(), 0.0)
        return workspace.world.motions.plan(checker, *[np.asarray(q.q)] * 2, seed=0, timeout=budget, iterations=1)

    return workspace.cache.value(("stands still", obj, grasp, q.q, others), found)


def _refuse(context: Context, result: MotionResult) -> None:
    """Say why there is no path, and because of what."""
    in_the_way = [fact for fact in context.fluents if fact[1] in result.bodies]
    context.fail(result.reason, because=in_the_way, proven=False)  # a random search that ended proves nothing


def _path(
    context: Context,
    scene: Scene,
    start: Configuration,
    goal: Configuration,
    margin: float,
    efforts: Sequence[tuple[float, int]],
) -> MotionResult:
    """The first path that one of the efforts finds: a margin of what is held [m], and iterations at most.

    All else keeps away by `margin` [m].
    """
    workspace: Workspace = context.scene
    ends = np.asarray(start.q), np.asarray(goal.q)
    seed = int(context.rng.integers(2**31))

    def guarded(held_margin: float) -> KnownChecker:
        return load_aware(workspace, scene, workspace.world.checker(scene, margin=margin, held_margin=held_margin))

    for held_margin, iterations in efforts:
        tight = guarded(min(margin, held_margin))
        checker = RoomyChecker(tight, guarded(held_margin), ends) if held_margin > margin else tight
        budget = max(context.deadline - clock.now(), 0.0)
        result = workspace.world.motions.plan(
            checker, *ends, seed=seed, timeout=budget, iterations=iterations, recheck=RECHECK
        )
        if result.path is not None:
            break
    return result
