"""Conservative advancement finds exactly what a look at every sample finds."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.distances import clearance
from tamp.checking.kinematics import read_kinematics
from tamp.checking.limits import interpolate
from tamp.checking.links import read_links
from tamp.checking.solids import Solid
from tamp.checking.sweep import Mover, sample_times, touches, travelled
from tamp.checking.transforms import inverse
from tamp.task import Box, Pose, load_robot
from tamp.task.mesh import parts
from tests.checking.handmade import timed

SPEC = load_robot("panda")
configurations = st.lists(st.floats(0.0, 1.0), min_size=7, max_size=7).map(
    lambda share: np.array(SPEC.lower) + np.array(share) * (np.array(SPEC.upper) - SPEC.lower)
)


def movers(q: np.ndarray) -> list[Mover]:
    placed = read_kinematics(SPEC).forward(q, 0.08)
    return [Mover(solid, placed[solid.name]) for solid in read_links(SPEC).solids]


@given(start=configurations, end=configurations)
@settings(max_examples=5, deadline=None)
def test_no_point_moves_further_than_the_step(start: np.ndarray, end: np.ndarray) -> None:
    motion = timed(np.array([start, end]), SPEC)
    times = sample_times(motion, movers, 0.005)
    for body in movers(interpolate(motion, times)):
        points = body.T[:, None, :3, :3] @ body.solid.hull.part.vertices[None, :, :, None]
        points = points[..., 0] + body.T[:, None, :3, 3]
        moved = np.linalg.norm(np.diff(points, axis=0), axis=2).max(axis=1)
        assert (moved <= 0.005 + 1e-9).all()
        assert (moved <= travelled(body.solid, body.T) + 1e-9).all()


@given(
    start=configurations,
    end=configurations,
    x=st.floats(-0.2, 0.3),
    y=st.floats(-0.5, 0.5),
    z=st.floats(0.0, 0.8),
    allowed=st.sampled_from([0.0, 0.001, 0.004]),
)
@settings(max_examples=12, deadline=None)
def test_advancement_equals_brute_force(
    start: np.ndarray, end: np.ndarray, x: float, y: float, z: float, allowed: float
) -> None:
    motion = timed(np.array([start, end]), SPEC)
    bodies = movers(interpolate(motion, sample_times(motion, movers, 0.02)))
    box = Mover(Solid.of("box", parts(Box((0.1, 0.2, 0.3)))), Pose((x, y, z)).matrix[None])
    for body in bodies:
        every = [clearance(box.solid, body.solid, inverse(box.T[0]) @ T, allowed) for T in body.T]
        deep = [k for k, apart in enumerate(every) if apart < -allowed]
        found = touches([(box, body, allowed)])
        assert [touch.sample for touch in found] == deep[:1]
