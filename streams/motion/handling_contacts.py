"""What arm, hand and held object meet on their way to a grasp, and off with it or down with it again."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tamp.streams.collisions import ARM_MARGIN, BESIDE, CONTACT_DEPTH, SCRAPED
from tamp.streams.context import Context
from tamp.streams.rubbing import close_together, dragged_over, rubbed, wedged
from tamp.streams.values import Grasp, Handling, Placement
from tamp.streams.workspace import Workspace
from tamp.task import Pose
from tamp.world.collision.checker import Contact
from tamp.world.collision.swept_boxes import swept_boxes
from tamp.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tamp.world.world import World


BENT = 2e-5  # farther from the line between its neighbours a point of a way is a bend; the arm errs by less [m]
DECIMALS = 5  # of where a way bends [m], so that two arm configurations bring an object the same way
DISTURBING = 3  # ways in which an object disturbs another one, after which it waits for that to go
EXACT = 1e-9  # lengths are divided by no less [m]


def test_cfree_handling(context: Context, obj: str, handling: Handling, other: str, standing: Placement) -> bool:
    """Whether the arm can reach for `obj` and lift it (or put it down and leave) while `other` stands there."""
    hits = handling_hits(context.scene, handling, {other: standing})
    for reason in hits.values():
        context.fail(reason)
    return not hits


def handling_hits(workspace: Workspace, handling: Handling, others: Mapping[str, Placement]) -> dict[str, str]:
    """Those of `others` that a handling would hit as they stand, each with its collision in words.

    Answers are remembered. All others are asked about at once: whoever is hit is taken away, until nobody is.
    """
    known: dict[tuple[str, Placement], str | None] = workspace.cache.value(("hits", handling), dict)
    asked = [name for name in sorted(others) if (name, others[name]) not in known]
    poses = {name: others[name].pose.matrix for name in asked if _may_meet(workspace, handling, name, others[name])}
    for name in [name for name in poses if _takes_along(workspace, handling, name, others[name])]:
        known[name, others[name]] = told(Contact(handling.object, name, 0.0))
        del poses[name]
    while poses and (contact := _handling_contact(workspace, handling, poses)) is not None:
        name = contact.a if contact.a in poses else contact.b
        known[name, others[name]] = told(contact)
        del poses[name]
    for name in asked:
        known.setdefault((name, others[name]), None)
    for name in others:
        if known[name, others[name]] is None and disturbs(workspace, handling, name, others[name]):
            known[name, others[name]] = f"{handling.object} or the hand would take {name} along"
    found = {name: known[name, others[name]] for name in sorted(others)}
    return {name: reason for name, reason in found.items() if reason is not None}


def learn_refused_beside(
    workspace: Workspace, handling: Handling, other: str, standing: Placement, *, by_any_grasp: bool
) -> None:
    """Let an object not be handled there again as something stands that somebody says is met or taken along."""
    grasp = None if by_any_grasp else handling.grasp
    workspace.cache.learn(_beside_key(handling, grasp, other, standing), True)


def learn_disturbed(
    workspace: Workspace, handling: Handling, other: str, standing: Placement, *, by_any_grasp: bool = True
) -> None:
    """Let an object not be handled so again beside another one, which it moves or meets by that, as somebody has seen.

    Where it did so in several ways, it is not handled at that placement at all while the other one stands there.
    """
    if disturbs(workspace, handling, other, standing):
        return
    learn_refused_beside(workspace, handling, other, standing, by_any_grasp=by_any_grasp)
    ways = _disturbing(workspace, handling, other, standing)
    workspace.cache.learn(("disturbed", handling.object, handling.placement, other, standing), ways + 1)


def _disturbing(workspace: Workspace, handling: Handling, other: str, standing: Placement) -> int:
    """In how many ways an object is known to disturb another one as it is let go at a placement."""
    return workspace.cache.value(("disturbed", handling.object, handling.placement, other, standing), int)


def disturbs(workspace: Workspace, handling: Handling, other: str, standing: Placement) -> bool:
    """Whether an object is known to move another one, or to meet it, as it is handled, though no contact tells."""
    if _disturbing(workspace, handling, other, standing) >= DISTURBING:
        return True
    keys = (_beside_key(handling, grasp, other, standing) for grasp in (None, handling.grasp))
    return any(workspace.cache.value(key, lambda: False) for key in keys)


def _beside_key(handling: Handling, grasp: Grasp | None, other: str, standing: Placement) -> Hashable:
    return "refused beside", handling.object, handling.let_go, grasp, other, standing


def _may_meet(workspace: Workspace, handling: Handling, name: str, standing: Placement) -> bool:
    """Whether the boxes around an object and around all that moves in a handling come near each other."""
    lower, upper = _room(workspace, handling)
    low, high = workspace.bounds(name, standing.pose)
    # The last box is round all others.
    if (lower[-1] > high + ARM_MARGIN).any() or (low - ARM_MARGIN > upper[-1]).any():
        return False
    return bool(((lower[:-1] < high + ARM_MARGIN) & (low - ARM_MARGIN < upper[:-1])).all(axis=1).any())


def _room(workspace: Workspace, handling: Handling) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of boxes that all that moves in a handling stays within, (n, 3) each [m], last one round all of them."""

    def found() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        robot, obj, grasp = workspace.world.robot, handling.object, handling.grasp
        T_tool_object = grasp.T_object_tool.inverse().matrix
        held = workspace.points(obj) @ T_tool_object[:3, :3].T + T_tool_object[:3, 3]
        empty = swept_boxes(robot, handling.approach, handling.opening)
        holding = swept_boxes(robot, handling.lift, grasp.width, held)
        falling = (workspace.bounds(obj, pose) for pose in handling.fall)
        lower, upper = map(np.vstack, zip(empty, holding, *falling, strict=True))
        return np.vstack([lower, lower.min(axis=0)]), np.vstack([upper, upper.max(axis=0)])

    return workspace.cache.value(("room", handling), found)


def _handling_contact(
    workspace: Workspace, handling: Handling, poses: Mapping[str, NDArray[np.float64]]
) -> Contact | None:
    obj, pose = handling.object, handling.let_go
    return (
        approach_contact(workspace, obj, pose, handling.opening, handling.approach, poses)
        or carrying_contact(workspace, obj, pose, handling.grasp, handling.lift, poses)
        or _fall_contact(workspace, handling, poses)
    )


def _fall_contact(workspace: Workspace, handling: Handling, poses: Mapping[str, NDArray[np.float64]]) -> Contact | None:
    world, obj, fall = workspace.world, handling.object, np.array([pose.matrix for pose in handling.fall])
    for name, T in poses.items() if len(fall) else ():
        near = world.overlaps(obj, fall[[0, -1]], name, T, tolerance=-BESIDE)
        depth = CONTACT_DEPTH if near else SCRAPED  # what it merely passes it does not graze
        for k in world.overlapping(obj, fall, name, T, tolerance=depth):
            return Contact(obj, name, world.separation(obj, fall[k], name, T))
    return None


def approach_contact(
    workspace: Workspace,
    obj: str,
    pose: Pose,
    opening: float,
    path: NDArray[np.float64],
    others: Mapping[str, NDArray[np.float64]],
    near: float = 0.0,
) -> Contact | None:
    """What the empty open hand meets on its way to a grasp of `obj`, shape of `path` (n, joints); None if nothing.

    To `obj` itself it may come as near as `near` [m].
    """
    scene = Scene(poses={**others, obj: pose.matrix}, opening=opening)
    return workspace.world.checker(scene, margin=ARM_MARGIN, touch={obj: near}).first_contact(path)


def lift_contact(
    workspace: Workspace,
    obj: str,
    grasp: Grasp,
    path: NDArray[np.float64],
    others: Mapping[str, NDArray[np.float64]],
) -> Contact | None:
    """What arm and held object meet while they leave the support; shape of `path` (n, joints); None if nothing.

    It is what `carrying_contact` tells, and what the object takes along by friction.
    """
    T_tool_object = grasp.T_object_tool.inverse().matrix
    passed = np.array([workspace.world.robot.forward(q) @ T_tool_object for q in path])
    return carrying_contact(workspace, obj, Pose.from_matrix(passed[0]), grasp, path, others) or _taken_along(
        workspace.world, obj, passed, others
    )


def carrying_contact(
    workspace: Workspace,
    obj: str,
    pose: Pose,
    grasp: Grasp,
    path: NDArray[np.float64],
    others: Mapping[str, NDArray[np.float64]],
) -> Contact | None:
    """What arm and held object meet as the object leaves its pose; shape of `path` (n, joints); None if nothing.

    What the object touches where it begins, it may touch on. All else it keeps clear of, and at the end of everything,
    since the motion on begins there.
    """
    scene = Scene(poses=others).attached(obj, grasp.T_object_tool.inverse().matrix, grasp.width)
    resting = touched(workspace.world, obj, pose.matrix, others, scraped=0.0)
    touch = {name: max(gap - SCRAPED, -CONTACT_DEPTH) for name, gap in resting.items()}
    leaving = workspace.world.checker(scene, margin=ARM_MARGIN, held_margin=0.0, held_touch=touch)
    gone = workspace.world.checker(scene, margin=ARM_MARGIN, held_margin=ARM_MARGIN)
    return leaving.first_contact(path) or gone.first_contact(path[-1:])


def _takes_along(workspace: Workspace, handling: Handling, name: str, standing: Placement) -> bool:
    """Whether an object takes another along as it is lifted; remembered for its way off, whatever arm and hand do."""
    way, obj, pose = _way_off(workspace, handling), handling.object, handling.let_go

    def found() -> bool:
        passed = np.repeat(pose.matrix[None], len(way), axis=0)
        passed[:, :3, 3] += way
        return _taken_along(workspace.world, obj, passed, {name: standing.pose.matrix}) is not None

    return workspace.cache.value(("takes along", obj, pose, way, name, standing), found)


def _way_off(workspace: Workspace, handling: Handling) -> tuple[tuple[float, ...], ...]:
    """How far an object is from where it begins at both ends of each straight piece of its lift [m]."""

    def found() -> tuple[tuple[float, ...], ...]:
        tools = np.array([workspace.world.robot.forward(q) for q in handling.lift])
        shifts = tools[:, :3, 3] - tools[0, :3, 3]
        return tuple(map(tuple, np.round(shifts[_bends(shifts)], DECIMALS).tolist()))

    return workspace.cache.value(("way off", handling), found)


def _bends(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Of points along straight pieces, shape (n, 3), those at the ends of each."""
    before, after = points[1:-1] - points[:-2], points[2:] - points[1:-1]
    beside = np.linalg.norm(np.cross(before, after), axis=1) / np.maximum(np.linalg.norm(before + after, axis=1), EXACT)
    return np.array([0, *(np.flatnonzero(beside > BENT) + 1), len(points) - 1])


def _taken_along(
    world: World, obj: str, passed: NDArray[np.float64], others: Mapping[str, NDArray[np.float64]]
) -> Contact | None:
    """What an object takes along by friction, as it passes some poses, shape (n, 4, 4), all turned alike.

    What it is not in where it begins it does not press on for long.
    """
    close = close_together(passed)
    resting = touched(world, obj, close[0], others, scraped=0.0)
    return (
        rubbed(world, obj, close, {name: T for name, T in others.items() if resting.get(name, -1.0) >= 0.0})
        or wedged(world, obj, close, others)
        or dragged_over(world, obj, close, others)
    )


def touched(
    world: World,
    obj: str,
    T: NDArray[np.float64],
    others: Mapping[str, NDArray[np.float64]],
    scraped: float = SCRAPED,
) -> dict[str, float]:
    """How near a held object may come to what it touches at rest at T: name, or "table" -> least distance [m].

    On its way it may be hardly deeper in those than it is at rest: by so much as is `scraped` [m].
    """
    resting = {name: world.separation(obj, T, name, others.get(name)) for name in world.beside(obj, T, others, BESIDE)}
    return {name: max(min(gap, 0.0) - scraped, -CONTACT_DEPTH) for name, gap in resting.items()}


def told(contact: Contact) -> str:
    """A contact in words."""
    return f"{contact.a} would hit {contact.b}"
