"""The ways to pinch one object: antipodal contacts from all directions, and what the object alone says of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.streams.hand.antipodal import Contacts, antipodal_contacts
from tamp.streams.surfaces import surface_points
from tamp.streams.values import CLEARANCE, Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Pose
from tamp.world.kinematics.freedom import confined
from tamp.world.robot.linkage import Linkage

if TYPE_CHECKING:
    from numpy.typing import NDArray

SURFACE = 400  # points that rays start from
DIRECTIONS = 16  # approach directions about the closing axis
OVERHANG = 0.02  # of an object over the table's edge, from which on a finger gets below it [m]
HANGING = 5  # points on the whole surface for each on what hangs over the table's edge
TILTS = (0.0, -0.12, 0.12, -0.25, 0.25, -0.4, 0.4)  # about its closing axis, of a hand that comes down [rad]
LEANING = tuple(np.linspace(-1.4, 1.4, 15).tolist())  # the same of one that comes down beside it [rad]
RISES = (-0.33, -0.26, -0.17, 0.17, 0.26, 0.33)  # of the closing axis: more, and a finger is in the table [rad]
NEARLY_LEVEL = 0.5  # how far a closing axis may point up that is made level
FRICTION_ANGLE = 0.35  # well inside the cone of rubber pads on plastic [rad]
WIDTH_RESERVE = 0.002  # the widest grasp leaves this much of the stroke [m]
PAD_SOFTNESS = 0.0015  # surface this near to a pad's plane is in contact [m]


@dataclass(frozen=True, eq=False)
class Pinches:
    """Many ways to pinch one object, in its own frame.

    Attributes:
        T_object_tool: shape (n, 4, 4).
        widths: distance between the pads, shape (n,) [m].
        depths: how far the contact lies behind the fingertips, shape (n,) [m].
        slants: angle between the closing axis and the surface normals, shape (n,) [rad].
        clearances: beside the object on each side before closing, shape (n,) [m].
    """

    T_object_tool: NDArray[np.float64]
    widths: NDArray[np.float64]
    depths: NDArray[np.float64]
    slants: NDArray[np.float64]
    clearances: NDArray[np.float64]

    def at(self, index: NDArray[Any]) -> Pinches:
        """Those at the given indices, or where a mask holds."""
        return Pinches(*(column[index] for column in self._columns))

    def opened(self, clearance: float) -> Pinches:
        """The same with so much room beside the object on each side before closing [m]."""
        return replace(self, clearances=np.full(len(self), clearance))

    def __len__(self) -> int:
        return len(self.widths)

    @staticmethod
    def none() -> Pinches:
        """No pinches."""
        return Pinches(np.empty((0, 4, 4)), *(np.empty(0) for _ in range(4)))

    @staticmethod
    def joined(several: Sequence[Pinches]) -> Pinches:
        """All of them, in order."""
        return Pinches(*(np.concatenate(column) for column in zip(*(p._columns for p in several), strict=True)))

    @property
    def _columns(self) -> tuple[NDArray[np.float64], ...]:
        return (self.T_object_tool, self.widths, self.depths, self.slants, self.clearances)


def sample_pinches(
    workspace: Workspace,
    obj: str,
    rng: np.random.Generator,
    points: int = SURFACE,
    hanging: Pose | None = None,
    low: Sequence[Pose] = (),
    tilts: Sequence[float] = (0.0,),
    rises: Sequence[float] = (0.0,),
) -> Pinches:
    """Every antipodal contact pair that rays from so many points find, from directions all around at every depth.

    An arm that cannot turn its tool every way would get to none of those: for it there are only hands that come down.
    Where the object hangs over the table's edge at a pose, rays start from about as many points of what hangs over.
    Where it lies low at some, pinches are added of hands that come down tilted so far about their closing axes, each of
    which rises by one of some angles [rad].
    """
    linkage = workspace.world.robot.linkage
    pieces = workspace.world.geometries[obj].parts
    surface = surface_points(pieces, points if hanging is None else HANGING * points, rng)
    if hanging is not None:
        surface = surface.at(beyond_table(workspace, surface.points @ hanging.matrix[:3, :3].T + hanging.xyz))
    widest = linkage.gripper.stroke - WIDTH_RESERVE
    contacts = antipodal_contacts(pieces, surface, max_width=widest, friction_angle=FRICTION_ANGLE, rng=rng)
    phase = rng.uniform(0.0, 2 * np.pi / DIRECTIONS, len(contacts.widths))
    directions = np.arange(0 if confined(workspace.world.robot) else DIRECTIONS)
    around = pinches_at(contacts, linkage, phase[:, None] + directions * 2 * np.pi / DIRECTIONS)
    level = (
        pinches_from_above(levelled(contacts, pose.matrix[2, :3], rise), linkage, pose, tilts)
        for pose, rise in product(low, rises)
    )
    return Pinches.joined([around, *level])


def levelled(contacts: Contacts, up: NDArray[np.float64], rise: float = 0.0) -> Contacts:
    """The nearly level of some contact pairs, turned about their middles until they rise by just one angle [rad].

    Of a thin thing that lies low a tilted hand has no room between it and the table. `up` is the upward direction in
    the object's frame, shape (3,). What the pads meet then, `closed` finds out.
    """
    contacts = contacts.at(np.abs(contacts.axes @ up) < NEARLY_LEVEL)
    level = contacts.axes - np.outer(contacts.axes @ up, up)
    axes = np.cos(rise) * level / np.linalg.norm(level, axis=1)[:, None] + np.sin(rise) * up
    return replace(contacts, axes=axes, widths=contacts.widths * np.einsum("ni,ni->n", axes, contacts.axes))


def pinches_from_above(contacts: Contacts, linkage: Linkage, pose: Pose, tilts: Sequence[float]) -> Pinches:
    """Pinches of contact pairs by hands that come down on an object at a pose, straight or a little tilted."""
    down = -pose.matrix[2, :3]
    u, v = sides(contacts.axes)
    return pinches_at(contacts, linkage, np.arctan2(v @ down, u @ down)[:, None] + np.array(tilts))


def beyond_table(workspace: Workspace, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points of the world, shape (n, 3), are beside the table."""
    table = workspace.task.table
    aside = np.abs(points[:, :2] - np.array(table.center)[:2]) - np.array(table.size)[:2] / 2
    beyond: NDArray[np.bool_] = (aside > 0.0).any(axis=1)
    return beyond


def hangs_over(workspace: Workspace, obj: str, place: Placement) -> bool:
    """Whether a finger may get below an object that hangs over the table's edge: few of all hands are there."""
    lower, upper = workspace.bounds(obj, place.pose)
    corners = np.array([lower + OVERHANG, upper - OVERHANG])
    return place.on == (TABLE,) and bool(beyond_table(workspace, corners).any())


def pinches_at(contacts: Contacts, linkage: Linkage, angles: NDArray[np.float64]) -> Pinches:
    """Pinches of every contact pair at every depth, the hand coming from some angles about its axis, (n, k) [rad].

    At zero it comes along the first of `sides`, at a right angle along the second.
    """
    gripper, axes, count = linkage.gripper, contacts.axes, angles.shape[1]
    depths = np.array(gripper.depths)
    u, v = sides(axes)
    approach = np.cos(angles)[:, :, None] * u[:, None] + np.sin(angles)[:, :, None] * v[:, None]
    y = np.repeat(axes[:, None], count, axis=1)
    R = np.stack([np.cross(y, approach), y, approach], axis=-1) @ linkage.axes
    # How far the tool is beyond the contacts: swinging pads are not always where the tool is.
    shift = (depths - gripper.pad[2] / 2) - linkage.depth(contacts.widths)[:, None]
    each = count * len(depths)
    T = np.tile(np.eye(4), (len(axes) * each, 1, 1))
    T[:, :3, :3] = np.repeat(R.reshape(-1, 3, 3), len(depths), axis=0)
    middles = contacts.centers[:, None, None] + approach[:, :, None] * shift[:, None, :, None]
    T[:, :3, 3] = middles.reshape(-1, 3)
    widths, slants = np.repeat(contacts.widths, each), np.repeat(contacts.slants, each)
    return Pinches(T, widths, np.tile(depths, len(axes) * count), slants, np.full(len(T), CLEARANCE))


def sides(axes: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two unit vectors across each axis and each other, (n, 3) each."""
    helper = np.where(np.abs(axes[:, :1]) < 0.8, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    u = np.cross(axes, helper)
    u /= np.linalg.norm(u, axis=1)[:, None]
    return u, np.cross(axes, u)


def intrinsic_cost(workspace: Workspace, obj: str, pinches: Pinches) -> NDArray[np.float64]:
    """What speaks against each pinch, (n,): small contact, long lever, slanted contact, shallow or wide grip."""
    gripper = workspace.world.robot.spec.gripper
    lever = np.linalg.norm(pinches.T_object_tool[:, :3, 3] - workspace.world.geometries[obj].center_of_mass, axis=1)
    shallow = np.where(pinches.depths < 0.005, 0.6, np.where(pinches.depths < 0.01, 0.1, 0.0))
    wide = np.maximum(pinches.widths / gripper.stroke - 0.85, 0) * 2.0
    cost: NDArray[np.float64] = (
        0.5 * (1 - _pad_contact(workspace, obj, pinches)) + 6.0 * lever + 4.0 * pinches.slants + shallow + wide
    )
    return cost


def _pad_contact(workspace: Workspace, obj: str, pinches: Pinches) -> NDArray[np.float64]:
    """How much of the less covered pad meets surface, relative to the best pinch of the object, shape (n,)."""
    gripper = workspace.world.robot.spec.gripper
    side, closing, _ = workspace.world.robot.linkage.axes
    local = in_tool_frames(workspace.surface[obj], pinches.T_object_tool)
    along, across = local @ closing, local @ side
    beyond = local[:, :, 2] - workspace.world.robot.linkage.depth(pinches.widths)[:, None]
    on_pad = (np.abs(across) < gripper.pad[1] / 2) & (np.abs(beyond) < gripper.pad[2] / 2)
    touched = [
        (on_pad & (np.abs(sign * along - pinches.widths[:, None] / 2) < PAD_SOFTNESS)).sum(axis=1) for sign in (-1, 1)
    ]
    least = np.minimum(*touched)
    share: NDArray[np.float64] = least / max(int(least.max()), 1)
    return share


def in_tool_frames(points: NDArray[np.float64], T_tool: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (m, 3) seen from many tools; `T_tool` (n, 4, 4) is given in the points' frame; shape (n, m, 3)."""
    R, t = T_tool[:, :3, :3], T_tool[:, :3, 3]
    # Coordinates first in memory, so that each can be compared as one array, and all of them as one product.
    local: NDArray[np.float64] = R.transpose(2, 0, 1).reshape(-1, 3) @ points.T
    local = local.reshape(3, len(T_tool), len(points))
    local -= np.einsum("nji,nj->in", R, t)[:, :, None]
    return local.transpose(1, 2, 0)
