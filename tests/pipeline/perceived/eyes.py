"""A quick perceiver for tests: boxes of one colour each, standing upright and square to the table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tamp.perception.cameras.camera import Frame
from tamp.perception.estimate import Estimate
from tamp.perception.rendering.surface import Surface
from tamp.task import Pose, Table

FEWEST = 12


def by_color(
    frames: Sequence[Frame], objects: Mapping[str, Surface], *, table: Table, seed: int
) -> dict[str, Estimate]:
    """The middle of what has an object's hue; half its height over the table."""
    assert table.size
    assert seed >= 0
    return {name: _one(frames, surface) for name, surface in objects.items()}


def _one(frames: Sequence[Frame], surface: Surface) -> Estimate:
    wanted = surface.colors[0] / np.linalg.norm(surface.colors[0].astype(float))
    found = []
    for frame in frames:
        color = frame.color / np.maximum(np.linalg.norm(frame.color.astype(float), axis=2), 1.0)[..., None]
        mask = (color @ wanted > 0.995) & (frame.depth > 0) & ~frame.robot
        local = frame.intrinsics.points(frame.depth)[mask]
        found.append(local @ frame.T_world_camera[:3, :3].T + frame.T_world_camera[:3, 3])
    points = np.concatenate(found) if found else np.empty((0, 3))
    if len(points) < FEWEST:
        return Estimate(None, 0.0)
    low, high = np.percentile(points[:, :2], 2, axis=0), np.percentile(points[:, :2], 98, axis=0)
    x, y = (low + high) / 2
    lifted = float(points[:, 2].max()) > 0.09
    assert not lifted, "nothing is looked at while it hangs in the air"
    return Estimate(Pose((float(x), float(y), -float(surface.vertices[:, 2].min()))), 0.9)


def nobody(frames: Sequence[Frame], objects: Mapping[str, Surface], *, table: Table, seed: int) -> dict[str, Estimate]:
    """Sees nothing."""
    return {name: Estimate(None, 0.0) for name in objects}
