"""Does what lies on the table rock over under what stands on it? By brute force: tilted, their weight comes down."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tamp.task import Box, Mesh
from tests.checking.oracle.bodies import Body, depth, within
from tests.checking.oracle.world import World

TILTS = np.arange(0.01, 0.25, 0.01)  # [rad]
WAYS = 24
NEAR = 0.002  # what is no higher over it stands on it [m]
LOW = 5e-4  # what is no higher over the table touches that [m]
LOWER = 0.001  # the middle of all the weight comes down by so much, clearly [m]
POINTS = 4000  # by which a middle is found


def rocking(world: World) -> dict[str, np.ndarray]:
    """Meshes on the table that boxes stand on, and tilt over for good: where they are then, the boxes too."""
    found = dict[str, np.ndarray]()
    for thing in world.task.objects:
        body, T = world.bodies[thing.name], world.poses[thing.name]
        low = (body.points @ T[2, :3] + T[2, 3]).min()
        if isinstance(thing.shape, Mesh) and abs(low) < LOW:
            riders = [other for other in world.others(thing.name, "table") if _rides(world, thing.name, other)]
            if riders and (tilt := _tilts(world, thing.name, riders)) is not None:
                found |= {name: tilt @ world.poses[name] for name in (thing.name, *riders)}
    return found


def _rides(world: World, name: str, other: str) -> bool:
    lowered = world.poses[other].copy()
    lowered[2, 3] -= NEAR
    touches = depth(world.bodies[other], lowered, world.bodies[name], world.poses[name]) > 0.0
    return touches and isinstance(world.task.object(other).shape, Box)


def _tilts(world: World, name: str, riders: list[str]) -> np.ndarray | None:
    """The turn, shape (4, 4), about an edge on the table that takes the weight of all lowest, all the way down."""
    T = world.poses[name]
    corners = world.bodies[name].points @ T[:3, :3].T + T[:3, 3]
    middles = np.array([world.poses[o][:3, 3] for o in riders] + [_middle(world.bodies[name], T)])
    masses = np.array([world.task.object(o).mass for o in (*riders, name)])
    middle, best, least = masses @ middles / masses.sum(), None, -LOWER
    for way in np.linspace(0.0, 2 * np.pi, WAYS, endpoint=False):
        axis, last = np.array([np.cos(way), np.sin(way), 0.0]), 0.0
        edge = corners[(corners @ Rotation.from_rotvec(axis * TILTS[0]).as_matrix()[2]).argmin()]
        for tilt in TILTS:
            R = Rotation.from_rotvec(axis * tilt).as_matrix()
            turn = np.eye(4)
            turn[:3, :3], turn[:3, 3] = R, edge - R @ edge
            turn[2, 3] -= ((corners - edge) @ R[2]).min()
            lower = float((turn[2, :3] @ middle) + turn[2, 3] - middle[2])
            if lower >= last:
                break
            last = lower
            if lower < least:
                best, least = turn, lower
    return best


def _middle(body: Body, T: np.ndarray) -> np.ndarray:
    points = np.random.default_rng(0).uniform(*body.box, (POINTS, 3))
    return T[:3, :3] @ points[within(body, np.eye(4), points)].mean(axis=0) + T[:3, 3]
