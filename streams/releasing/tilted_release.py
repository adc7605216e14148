"""Tilted release: an object that the hand cannot bring all the way is let go, and falls what is left of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice

from tamp import clock
from tamp.streams.affordances.falls import drops, refused
from tamp.streams.affordances.neighbours import carriers, standing_around
from tamp.streams.affordances.stable_poses import midtable
from tamp.streams.affordances.stable_poses import moved as moved_to
from tamp.streams.affordances.tilts import layable, tilts
from tamp.streams.context import Context
from tamp.streams.hand.candidates import beyond_table, hangs_over
from tamp.streams.hand.clearance import hand_hits, opening_for
from tamp.streams.hand.finger_closing import between_pads
from tamp.streams.motion.inverse_kinematics import BESIDE, FALLING_PAST, handlings, reaches
from tamp.streams.releasing.edge_contact import dragged, held_up, hooked, turned_off
from tamp.streams.releasing.landing import aimed, sure_on_table, whole_on_table
from tamp.streams.values import Configuration, Grasp, Handling, Placement, falls_straight
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.scene import Scene
from tamp.world.transforms import moved

TRIED = 3  # falls from the least to the farthest that tell whether an object can be laid down at all ...
FURTHER = 3  # ... tried so often, where none of them lands as it shall
MISSES = 9  # falls in a row that land elsewhere, after which the object is taken to land there from nowhere
ON_EDGE = 0.004  # the edge is at most this far above what it is set on [m]


def plan_laying(
    context: Context, obj: str, placement: Placement, grasp: Grasp
) -> Iterator[tuple[Configuration, Configuration, Handling]]:
    """Yield (approach configuration, lift configuration, handling) that let an object fall to a placement.

    Read as those of `inverse_kinematics`: the handling ends where the object is let go.
    """
    for fall in _falls(context, obj, placement, grasp):
        if clock.now() > context.deadline:
            return
        yield from handlings(context, obj, placement, grasp, fall)


def plan_bringing(
    context: Context, obj: str, placement: Placement, grasp: Grasp
) -> Iterator[tuple[Configuration, Configuration, Handling]]:
    """Yield (approach configuration, lift configuration, handling) that put an object down, then those that lay it."""
    yield from handlings(context, obj, placement, grasp)
    yield from plan_laying(context, obj, placement, grasp)


def lays(context: Context, obj: str, placement: Placement, grasp: Grasp) -> bool:
    """Whether an object can be let fall to a placement, were nothing else on the table than what carries it there."""
    falls = _falls(context, obj, placement, grasp, TRIED)
    return any(reaches(context, obj, placement, grasp, fall) for fall in falls)


def letting_go_at(context: Context, obj: str, placement: Placement, grasp: Grasp) -> list[Pose]:
    """Poses from which an object may fall to a placement: those for which `lays` asks whether the arm gets there."""
    return [fall[0] for fall in _falls(context, obj, placement, grasp, TRIED)]


def falls_flat(workspace: Workspace, obj: str, placement: Placement, grasp: Grasp, *, surely: bool = False) -> bool:
    """Whether an object falls to a placement on the table from some tilt in which the hand may let it go there.

    Surely, if it does so too when it is let go a little otherwise.
    """
    at = midtable(workspace, placement)
    ways, _ = _roomy(workspace, obj, at, grasp, layable(workspace, obj, placement))
    landed = (_landing(workspace, obj, at, grasp, fall) for fall in _spread(ways, TRIED))
    return any(fall and (not surely or _is_sure(workspace, obj, at, fall)) for fall in landed)


def _falls(
    context: Context, obj: str, placement: Placement, grasp: Grasp, most: int | None = None
) -> Iterator[tuple[Pose, ...]]:
    """Ways to fall to a placement that leave room for the hand that lets go; a reason is told where there are none.

    At most so many are taken, from the least to the farthest.
    """
    workspace: Workspace = context.scene
    on_table = whole_on_table(workspace, obj, placement)
    at = midtable(workspace, placement) if on_table else placement
    ways, reason = _roomy(workspace, obj, at, grasp, layable(workspace, obj, placement))
    found = None
    beside = False
    for found in islice(_landings(context, obj, at, grasp, _spread(ways, most)), most):
        fall = moved_to(found, placement) if on_table else found
        if placement.on == (TABLE,) and _beside_table(workspace, obj, fall[0]):
            beside = True
        elif refused(workspace, obj, placement, fall[0]):
            context.fail(f"{obj} would upset what it falls onto")
        else:
            yield fall
    if beside:
        context.fail(f"{obj} would be set on an edge beside the table")
    if found is None:
        context.fail(f"{obj} would not fall there" if ways else reason)


def _beside_table(workspace: Workspace, obj: str, let_go: Pose) -> bool:
    """Whether an object's edge, on which it is let go, is beside the table, over whose edge it may reach as it lies."""
    T = let_go.matrix
    corners = workspace.world.geometries[obj].hull.vertices @ T[:3, :3].T + T[:3, 3]
    return bool(beyond_table(workspace, corners[corners[:, 2] < corners[:, 2].min() + ON_EDGE]).all())


def _landings(
    context: Context, obj: str, placement: Placement, grasp: Grasp, ways: Sequence[tuple[Pose, ...]]
) -> Iterator[tuple[Pose, ...]]:
    """The ways to fall, as the object lands, that end at its placement, until too many in a row end elsewhere.

    Those come last that would, were the object let go on the table a little otherwise.
    """
    misses, unsure = 0, list[tuple[Pose, ...]]()
    for way in ways:
        if misses == MISSES or clock.now() > context.deadline:
            break
        landed = _landing(context.scene, obj, placement, grasp, way)
        if landed is not None and _is_sure(context.scene, obj, placement, landed):
            misses = 0
            yield landed
        else:
            misses += 1
            unsure += [] if landed is None else [landed]
    yield from unsure


def _is_sure(workspace: Workspace, obj: str, placement: Placement, fall: tuple[Pose, ...]) -> bool:
    straight = falls_straight(fall[0], placement.pose)
    return straight or not whole_on_table(workspace, obj, placement) or sure_on_table(workspace, obj, fall)


def _spread(ways: Sequence[tuple[Pose, ...]], most: int | None) -> list[tuple[Pose, ...]]:
    """All of the ways; or so many of them, from the least to the farthest, then those beside these, a few times."""
    step = -(-len(ways) // most) if most and ways else 1
    return [way for first in range(min(step, FURTHER)) for way in ways[first::step]]


def _roomy(
    workspace: Workspace, obj: str, placement: Placement, grasp: Grasp, able: bool
) -> tuple[list[tuple[Pose, ...]], str]:
    """Ways to fall that leave room for the hand, straight ones first, and why there are none.

    The hand must not drag the object along either as it draws back; what lies in something is kept there by its walls.
    `able` says whether the object may be laid down there at all.
    """

    def found() -> tuple[list[tuple[Pose, ...]], str]:
        straight = drops(workspace, obj, placement)
        stands = TABLE in placement.on or not below.keys().isdisjoint(placement.on)
        over = [tilt.fall for tilt in tilts(workspace, obj, placement)] if able and stands else []
        ways = [*straight, *over]
        roomy = [fall for fall in ways if _room(workspace, obj, placement, grasp, fall[0])]
        left = [fall for fall in roomy if straight or not _taken_along(workspace, obj, placement, grasp, fall)]
        reason = f"the hand would hit what {obj} falls on" if ways else f"{obj} cannot be set on an edge there"
        return left, f"the hand would drag {obj} along as it draws back" if roomy else reason

    below = carriers(workspace, obj, placement)
    return workspace.cache.value(("falls", obj, placement, grasp, able, *below.items()), found)


def _landing(
    workspace: Workspace, obj: str, placement: Placement, grasp: Grasp, fall: tuple[Pose, ...]
) -> tuple[Pose, ...] | None:
    """A way to fall, as the object lands; None where it does so elsewhere, or the hand has no room, or no way back."""
    if falls_straight(fall[0], placement.pose):
        return fall
    aim = _over_edge(workspace, obj, placement, fall)
    if aim is None or not _room(workspace, obj, placement, grasp, aim[0]):
        return None
    return aim if _gets_away(workspace, obj, grasp, aim) else None


def _gets_away(workspace: Workspace, obj: str, grasp: Grasp, fall: tuple[Pose, ...]) -> bool:
    """Whether there is a way back for a hand past an object that turns over its edge; the arm is left out."""
    gripper, T = workspace.world.robot.spec.gripper, fall[0].matrix @ grasp.T_object_tool.matrix
    opening, scenes = opening_for(gripper, grasp), [Scene({obj: pose.matrix}) for pose in fall]
    for back in workspace.hand.approaches:
        T_away = moved(T, -back * T[:3, 2])
        held = between_pads(workspace, obj, fall[-1].inverse().matrix @ T_away, gripper.stroke, -BESIDE)
        if len(held) == 0:
            met = (workspace.world.hand_contact(T_away, opening, at, FALLING_PAST, ignore=(TABLE,)) for at in scenes)
            if not any(met):
                return True
    return False


def _taken_along(workspace: Workspace, obj: str, placement: Placement, grasp: Grasp, fall: tuple[Pose, ...]) -> bool:
    """Whether an object that turns over its edge goes with the hand that draws back, or off the table beside it."""
    if hangs_over(workspace, obj, placement) and turned_off(workspace, obj, placement, grasp, fall[0]):
        return True
    return dragged(workspace, obj, placement, grasp, fall[0]) or hooked(workspace, obj, grasp, fall)


def _over_edge(workspace: Workspace, obj: str, placement: Placement, fall: tuple[Pose, ...]) -> tuple[Pose, ...] | None:
    """A fall over an edge that is set on what the object is to lie on, as it lands there; None where it does not."""
    around = standing_around(workspace, obj, placement)
    below = {name: around[name] for name in placement.on if name in around}
    if TABLE not in placement.on and not _on_edge(workspace, obj, fall, below):
        return None
    aim = aimed(workspace, obj, placement, fall)
    return aim if aim is None or TABLE in placement.on or _on_edge(workspace, obj, aim, below) else None


def _on_edge(workspace: Workspace, obj: str, fall: tuple[Pose, ...], below: Mapping[str, Placement]) -> bool:
    """Whether the object as it is let go touches what it is to lie on, and may turn about its edge there."""
    return any(
        workspace.world.separation(obj, fall[0].matrix, name, place.pose.matrix) < ON_EDGE
        for name, place in below.items()
    ) and not held_up(workspace, obj, fall, below)


def _room(workspace: Workspace, obj: str, placement: Placement, grasp: Grasp, let_go: Pose) -> bool:
    """Whether the open hand is clear of the table and of what the object is to lie on or in."""
    below = carriers(workspace, obj, placement)
    supports = Scene(poses={name: place.pose.matrix for name, place in below.items()})
    opening = opening_for(workspace.world.robot.spec.gripper, grasp)
    return not hand_hits(workspace, let_go.matrix @ grasp.T_object_tool.matrix, opening, supports)
