"""Conservative advancement finds what a look at every sample finds, and what is between two of them."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.geometry.solids import Solid, clearance
from tamp.checking.geometry.transforms import inverse
from tamp.checking.robot.cubic import interpolate
from tamp.checking.robot.kinematics import read_kinematics
from tamp.checking.robot.links import read_links
from tamp.checking.robot.sweep import Mover, looks, passed, touches, travelled
from tamp.task import Box, Pose, Trajectory, load_robot
from tamp.task.mesh.parts import Part, parts
from tests.checking.handmade import timed

SPEC = load_robot("panda")
configurations = st.lists(st.floats(0.0, 1.0), min_size=7, max_size=7).map(
    lambda share: np.array(SPEC.lower) + np.array(share) * (np.array(SPEC.upper) - SPEC.lower)
)


def movers(q: np.ndarray) -> list[Mover]:
    placed = read_kinematics(SPEC).forward(q, 0.08)
    return [Mover(solid, placed[solid.name]) for solid in read_links(SPEC).solids]


def seen(motion: Trajectory, step: float) -> np.ndarray:
    found = looks(motion, movers, step, read_links(SPEC).reach, 100_000)
    assert found is not None
    return found.times


def corners(body: Mover) -> np.ndarray:
    """Where a body's corners are, shape (n, corners, 3)."""
    points = body.T[:, None, :3, :3] @ body.solid.hull.part.vertices[None, :, :, None]
    return points[..., 0] + body.T[:, None, :3, 3]


def flung(start: np.ndarray, end: np.ndarray, first: np.ndarray, last: np.ndarray) -> Trajectory:
    """One span of a cubic, however fast at its ends."""
    return Trajectory(np.array([0.0, 1.0]), np.array([start, end]), np.array([first, last]))


speeds = st.lists(st.floats(-2.0, 2.0), min_size=7, max_size=7).map(np.array)


@given(start=configurations, end=configurations, first=speeds, last=speeds)
@settings(max_examples=5, deadline=None)
def test_no_point_moves_further_than_the_step_between_two_looks(
    start: np.ndarray, end: np.ndarray, first: np.ndarray, last: np.ndarray
) -> None:
    step = 0.02
    for motion in (timed(np.array([start, end]), SPEC), flung(start, start + (end - start) / 4, first, last)):
        times = seen(motion, step)
        between = [a + share * (b - a) for a, b in pairwise(times) for share in (0, 0.3, 0.6, 1)]
        for body in movers(interpolate(motion, np.array(between))):
            at = corners(body).reshape(len(times) - 1, 4, -1, 3)
            assert (np.linalg.norm(at - at[:, :1], axis=3) <= step + 1e-9).all()


def test_what_comes_back_between_two_samples_is_seen() -> None:
    still, fast = np.array(SPEC.home), np.eye(7)[1] * 2.0
    times = seen(flung(still, still, fast, -fast), 0.005)
    heights = read_kinematics(SPEC).tool(interpolate(flung(still, still, fast, -fast), times))[:, 2, 3]
    assert np.ptp(heights) > 0.2


def test_a_motion_too_wild_to_be_looked_at_is_none() -> None:
    still, fast = np.array(SPEC.home), np.full(7, 1e9)
    assert looks(flung(still, still, fast, -fast), movers, 0.005, 1.0, 10_000) is None


@given(start=configurations, end=configurations)
@settings(max_examples=5, deadline=None)
def test_travel_is_a_bound(start: np.ndarray, end: np.ndarray) -> None:
    for body in movers(np.array([start, end])):
        assert (
            np.linalg.norm(np.diff(corners(body), axis=0), axis=2).max() <= travelled(body.solid, body.T) + 1e-9
        ).all()


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
    bodies = movers(interpolate(motion, seen(motion, 0.02)))
    box = Mover(Solid.of("box", parts(Box((0.1, 0.2, 0.3)))), Pose((x, y, z)).matrix[None])
    for body in bodies:
        every = [clearance(box.solid, body.solid, inverse(box.T[0]) @ T, allowed) for T in body.T]
        deep = [k for k, apart in enumerate(every) if apart < -allowed]
        found = [touch.sample for touch in touches([(box, body, allowed)])]
        if found[:1] != deep[:1]:  # seen between two looks: no sooner than they may meet there
            assert found and (not deep or found[0] < deep[0])
            assert every[found[0]] < 0.02


@given(start=configurations, end=configurations)
@settings(max_examples=5, deadline=None)
def test_what_is_left_out_as_far_away_is_never_touched(start: np.ndarray, end: np.ndarray) -> None:
    motion = timed(np.array([start, end]), SPEC)
    bodies = movers(interpolate(motion, seen(motion, 0.02)))
    crate = [part for x in (-0.04, 0.04) for part in _shifted(parts(Box((0.02, 0.1, 0.1))), x)]
    grid = [(x, y, z) for x in (-0.6, 0.0, 0.6) for y in (-0.6, 0.0, 0.6) for z in (0.1, 0.7, 2.0)]
    still = [Mover(Solid.of(f"crate {at}", crate), Pose(at).matrix[None].copy()) for at in grid]
    near = passed(bodies, still)
    assert 0 < len(near) < len(still)
    assert touches((a, b, 0.0) for a in near for b in bodies) == touches((a, b, 0.0) for a in still for b in bodies)


def _shifted(pieces: Iterable[Part], x: float) -> list[Part]:
    return [Part(piece.vertices + np.array([x, 0.0, 0.0]), piece.faces) for piece in pieces]


@pytest.mark.parametrize("thick", [0.001, 0.002, 0.004])
@pytest.mark.parametrize("first", [0.0, 0.0013, 0.0027])
def test_thin_bodies_do_not_pass_through_each_other_between_two_looks(thick: float, first: float) -> None:
    """No look sees them in each other, or none deeper than half of what both are thick."""
    card, wall = (Solid.of(name, parts(Box((thick, 0.06, 0.06)))) for name in ("card", "wall"))
    places = np.arange(-0.05, 0.05, 0.005) + first
    path = np.tile(np.eye(4), (len(places), 1, 1))
    path[:, 0, 3] = places
    for at, meets in ((0.0, True), (0.07, False)):
        beside = np.eye(4)
        beside[1, 3] = at
        assert bool(touches([(Mover(wall, beside[None]), Mover(card, path), 0.001)])) == meets
