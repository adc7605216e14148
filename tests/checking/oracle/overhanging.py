"""Does what was put down tip off all that it touches? By brute force: its middle is beside that, as seen from above."""

from __future__ import annotations

import numpy as np

from tests.checking.oracle.bodies import Body, within
from tests.checking.oracle.lying import raised_by, up_to_touch
from tests.checking.oracle.world import World

TOUCHING = 0.001  # points nearer to another body than this touch it [m]
BESIDE = 0.01  # so far beside all of them a middle is clearly not carried [m]
ALIKE = 0.006  # where all of them are within this height, they pinch nothing so that it stays level [m]
DRAWN = 6000  # points by which a middle is found
WAYS = 72


def tips_off(world: World, name: str) -> str | None:
    """That an object's middle is beside all that it touches, which is all at one height; or None."""
    body, T = world.bodies[name], world.poses[name]
    T = raised_by(T, up_to_touch(world, body, T, world.others(name)))  # as it stands once it has come down
    touching, under = [np.zeros((0, 3))], []
    for other, at in world.others(name).items():
        points = np.vstack([_near(body, T, world.bodies[other], at), _near(world.bodies[other], at, body, T)])
        touching.append(points)
        under += [other] if len(points) else []
    points = np.vstack(touching)
    if not len(points) or np.ptp(points[:, 2]) > ALIKE:
        return None
    drawn = np.random.default_rng(0).uniform(*body.box, (DRAWN, 3))
    middle = T[:3, :3] @ drawn[within(body, np.eye(4), drawn)].mean(axis=0) + T[:3, 3]
    angle = np.linspace(0.0, 2 * np.pi, WAYS, endpoint=False)
    fan = np.stack([np.cos(angle), np.sin(angle)])
    beside = float((middle[:2] @ fan - (points[:, :2] @ fan).max(axis=0)).max())
    return f"{name} tips off {' and '.join(sorted(under))}" if beside > BESIDE else None


def _near(one: Body, T_one: np.ndarray, two: Body, T_two: np.ndarray) -> np.ndarray:
    """Surface points of one body, in the world, that touch another."""
    points = one.points @ T_one[:3, :3].T + T_one[:3, 3]
    local = (points - T_two[:3, 3]) @ T_two[:3, :3]
    far = np.min([(local @ planes[:, :3].T + planes[:, 3]).max(axis=1) for planes in two.planes], axis=0)
    return points[far < TOUCHING]
