"""Ways for a body to rest: where each facet that does not carry it topples to."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.task.mesh.parts import convex_hull
from tamp.world.geometry.stable_poses import resting_poses


def test_toppling_ends_on_a_round_thing_as_a_scan_has_it() -> None:
    """Noise makes slivers, whose normals say that a body on them topples up, onto where it came from."""
    rng = np.random.default_rng(0)
    angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    ring = 0.008 * np.column_stack([np.cos(angle), np.sin(angle)])
    marker = np.concatenate([np.column_stack([ring, np.full(48, z)]) for z in np.linspace(-0.06, 0.06, 8)])
    poses = resting_poses(convex_hull(marker + 1e-4 * rng.normal(size=marker.shape)), np.zeros(3))
    assert sum(pose.probability for pose in poses) == pytest.approx(1)
    lying = [pose for pose in poses if abs(pose.R[2, 2]) < 0.1]
    assert sum(pose.probability for pose in lying) > 0.9
    assert all(pose.height == pytest.approx(0.008, abs=5e-4) for pose in lying)
