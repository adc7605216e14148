"""Does what was put down lie down further on what is under it? By brute force: tilted, its middle comes down."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from tamp.task import Mesh
from tests.checking.oracle.bodies import Body, depth, within
from tests.checking.oracle.world import World

TILTS = np.arange(0.02, 0.31, 0.02)  # [rad]
WAYS = 24
TOUCHING = 0.004  # what meets another body when it is lowered so far stands on it [m]
LOWER = 0.001  # its middle comes down by so much, clearly [m]
FAR = 0.02  # and some point of it moves so far [m]
POINTS = 6000  # by which a middle is found


def lies_down(world: World, name: str) -> str | None:
    """That an object of several pieces tips on down on the bodies that it stands on; or None."""
    body, T = world.bodies[name], world.poses[name]
    if not isinstance(world.task.object(name).shape, Mesh) or len(body.planes) < 2:
        return None
    lowered = raised_by(T, -TOUCHING)
    under = {o: at for o, at in world.others(name).items() if depth(body, lowered, world.bodies[o], at) > 0.0}
    if not under:
        return None
    drawn = np.random.default_rng(0).uniform(*body.box, (POINTS, 3))
    middle = drawn[within(body, np.eye(4), drawn)].mean(axis=0)
    begins = raised_by(T, up_to_touch(world, body, T, under))
    for way in np.linspace(0.0, 2 * np.pi, WAYS, endpoint=False):
        axis, last = np.array([np.cos(way), np.sin(way), 0.0]), float(begins[2, :3] @ middle + begins[2, 3])
        high = last
        for tilt in TILTS:
            turned = begins.copy()
            turned[:3, :3] = Rotation.from_rotvec(axis * tilt).as_matrix() @ begins[:3, :3]
            turned[:3, 3] += (begins[:3, :3] - turned[:3, :3]) @ middle
            turned = raised_by(turned, up_to_touch(world, body, turned, under))
            height = float(turned[2, :3] @ middle + turned[2, 3])
            if height >= last:
                break
            last = height
            moved = np.linalg.norm(body.points @ (turned - begins)[:3, :3].T + (turned - begins)[:3, 3], axis=1)
            if high - height > LOWER and moved.max() > FAR:
                return f"{name} lies down further on {' and '.join(sorted(under))}"
    return None


def raised_by(T: np.ndarray, by: float) -> np.ndarray:
    """A pose, moved up [m]."""
    raised = T.copy()
    raised[2, 3] += by
    return raised


def up_to_touch(world: World, body: Body, T: np.ndarray, under: Mapping[str, np.ndarray]) -> float:
    """How far a body at T must go up, or may come down, to just touch others, each where it stands [m]."""
    low, high = -0.05, 0.05
    for _ in range(13):
        half = (low + high) / 2
        meets = any(depth(body, raised_by(T, half), world.bodies[o], at) > 0.0 for o, at in under.items())
        low, high = (half, high) if meets else (low, half)
    return high
