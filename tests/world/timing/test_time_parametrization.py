from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tamp.checking.robot.trajectory_limits import violations
from tamp.checking.tolerances import Tolerances
from tamp.task import Trajectory, load_robot
from tamp.world.timing.blending import rounded
from tamp.world.timing.time_parametrization import SAMPLE_S, time_free_path, time_path
from tamp.world.timing.trajectory import (
    accelerations,
    first_blocked,
    largest_deviation,
    largest_jerk,
    peak_velocities,
    positions_at,
)

PANDA = load_robot("panda")
LOWER, UPPER = np.array(PANDA.lower), np.array(PANDA.upper)
HOME = np.array(PANDA.home)


def random_path(seed, edges, scale):
    rng = np.random.default_rng(seed)
    waypoints = [rng.uniform(LOWER, UPPER)]
    for _ in range(edges):
        waypoints.append(np.clip(waypoints[-1] + scale * rng.normal(size=7), LOWER, UPPER))
    return np.array(waypoints)


random_paths = st.builds(random_path, st.integers(0, 2**32 - 1), st.integers(1, 12), st.sampled_from([1e-3, 0.05, 0.6]))


@settings(max_examples=60, deadline=None)
@given(random_paths, st.sampled_from([1.0, 0.3]))
def test_limits_hold_and_the_path_is_kept(path, speed):
    trajectory = time_path(path, PANDA, speed=speed)
    assert not list(violations(trajectory, PANDA, Tolerances()))
    assert (np.abs(trajectory.velocities) <= speed * np.array(PANDA.velocity) * 1.001).all()
    assert (np.abs(accelerations(trajectory)) <= speed * np.array(PANDA.acceleration) * 1.001).all()
    assert largest_deviation(trajectory, path) < 0.005
    assert np.diff(trajectory.times).min() > 0 and np.diff(trajectory.times).max() <= SAMPLE_S * 1.001
    assert trajectory.times[0] == 0.0
    assert not trajectory.velocities[[0, -1]].any()
    assert trajectory.positions[[0, -1]] == pytest.approx(path[[0, -1]], abs=2e-6)


def test_a_long_edge_reaches_the_velocity_limit_of_a_joint():
    goal = HOME.copy()
    goal[0] += 2.0
    trajectory = time_path(np.array([HOME, goal]), PANDA)
    assert np.abs(trajectory.velocities[:, 0]).max() == pytest.approx(PANDA.velocity[0], rel=1e-3)
    bang_bang = 2.0 / PANDA.velocity[0] + PANDA.velocity[0] / PANDA.acceleration[0]
    assert trajectory.duration == pytest.approx(bang_bang, rel=0.01)


def test_there_and_back_again_stops_at_the_turn():
    goal = HOME + 0.3
    trajectory = time_path(np.array([HOME, goal, HOME]), PANDA)
    assert not list(violations(trajectory, PANDA, Tolerances()))
    assert largest_deviation(trajectory, np.array([HOME, goal])) < 1e-6


@pytest.mark.parametrize("copies", [1, 2, 5])
def test_a_path_of_no_length_stands_still(copies):
    trajectory = time_path(np.repeat(HOME[None], copies, axis=0), PANDA)
    assert trajectory.times.tolist() == [0.0, SAMPLE_S]
    assert (trajectory.positions == HOME).all() and not trajectory.velocities.any()


def test_duplicates_change_nothing():
    path = random_path(3, 4, 0.5)
    assert (time_path(np.repeat(path, 3, axis=0), PANDA).positions == time_path(path, PANDA).positions).all()


def test_slower_is_longer_and_gentler():
    path = random_path(1, 3, 0.5)
    fast, slow = time_path(path, PANDA), time_path(path, PANDA, speed=0.25)
    assert slow.duration > 1.9 * fast.duration
    assert (largest_jerk(slow) < largest_jerk(fast)).all()


@pytest.mark.parametrize(
    ("path", "speed", "message"),
    [
        (np.zeros((2, 6)), 1.0, r"shape \(n, 7\)"),
        (np.full((2, 7), np.nan), 1.0, "not finite"),
        (np.array([HOME, HOME + 4.0]), 1.0, "waypoint 1 has panda_joint1 at 4.0000, beyond"),
        (HOME[None], 0.0, r"in \(0, 1\], not 0.0"),
        (HOME[None], 1.5, r"in \(0, 1\], not 1.5"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(path, speed, message):
    with pytest.raises(ValueError, match=message):
        time_path(path, PANDA, speed=speed)


class Corner:
    """Blocks whatever strays from a polyline by more than `room` [rad]."""

    def travel(self, configurations):
        return 1.2 * np.abs(np.diff(configurations, axis=0)).sum(axis=1)

    def __init__(self, path, room):
        self.path, self.room = path, room

    def free(self, q):
        return bool(deviation_of(q, self.path) <= self.room)


def deviation_of(q, path):
    from tamp.world.motion.paths import deviation

    return deviation(q[None], path)[0]


def test_corners_are_cut_less_where_the_cut_would_touch():
    path = HOME + 0.5 * np.array([np.zeros(7), np.eye(7)[0], np.eye(7)[0] + np.eye(7)[1]])
    wide, narrow = (time_free_path(path, PANDA, Corner(path, room)).trajectory for room in (0.01, 0.001))
    assert largest_deviation(narrow, path) <= 0.001 < largest_deviation(wide, path)
    assert narrow.duration > wide.duration


def test_a_timed_curve_that_touches_is_refused_with_its_time():
    path = np.array([HOME, HOME + 0.2])
    timed = time_free_path(path, PANDA, Corner(path[:1], 0.3))
    assert timed.trajectory is None
    assert timed.reason.startswith("the timed motion touches something 0.")


def test_every_centimetre_is_tested():
    class Counter:
        def travel(self, configurations):
            return np.abs(np.diff(configurations, axis=0)) @ [1.2, 1.1, 1.0, 0.8, 0.6, 0.4, 0.2]

        def __init__(self):
            self.seen = []

        def free(self, q):
            self.seen.append(q)
            return True

    checker = Counter()
    trajectory = time_path(np.array([HOME, HOME + 0.2]), PANDA)
    assert first_blocked(trajectory, checker, 0.01) is None
    moved = checker.travel(checker.seen)
    assert moved.max() <= 0.0101 and len(checker.seen) < 130
    assert checker.seen[0] == pytest.approx(HOME) and checker.seen[-1] == pytest.approx(HOME + 0.2)


@settings(max_examples=40, deadline=None)
@given(random_paths)
def test_rounded_paths_are_smooth_and_near(path):
    curve = rounded(path, 0.004)
    s = np.sort(np.concatenate([np.linspace(0, curve.arc[-1], 300), curve.breaks]))
    h = 1e-7 * curve.arc[-1]
    inner = s[(s > 2 * h) & (s < curve.arc[-1] - 2 * h)]
    slope = (curve(inner + h) - curve(inner - h)) / (2 * h)
    assert slope == pytest.approx(curve(inner, 1), abs=1e-4)
    corner = np.linalg.norm(curve(curve.arc) - path, axis=1)
    assert corner.max() <= 0.004 + 1e-9


def test_other_robots_have_other_limits():
    path = random_path(5, 3, 0.5)
    weak = replace(PANDA, acceleration=tuple(a / 4 for a in PANDA.acceleration))
    assert (np.abs(accelerations(time_path(path, weak))) <= np.array(weak.acceleration) * 1.001).all()


@given(
    q=arrays(np.float64, (5, 2), elements=st.floats(-1.0, 1.0)),
    v=arrays(np.float64, (5, 2), elements=st.floats(-2.0, 2.0)),
    spans=arrays(np.float64, 4, elements=st.floats(0.05, 1.0)),
)
def test_velocities_between_samples_are_those_of_the_curve(q, v, spans):
    times = np.concatenate([[0.0], np.cumsum(spans)])
    trajectory = Trajectory(times, q, v)
    for start, end, peak in zip(times[:-1], times[1:], peak_velocities(trajectory), strict=True):
        at = np.linspace(start, end, 401)
        felt = np.abs(np.diff(positions_at(trajectory, at), axis=0)).max(axis=0) / (at[1] - at[0])
        assert (felt <= peak + 1e-6).all()
        assert (felt >= peak - 0.02 * (1.0 + peak)).all()


def test_a_curve_that_is_fastest_between_its_samples_is_stretched(monkeypatch):
    """As an average of motions is here and there, by a part in a thousand."""
    limit, times = np.array(PANDA.velocity), np.array([0.0, 0.1, 0.2])
    way = 0.07 * limit * np.array([[-1.0], [0.0], [1.0]])
    hasty = Trajectory(times, way, np.array([[0.0], [0.9], [0.0]]) * limit)
    ratio = (peak_velocities(hasty) / limit).max()
    assert ratio > 0.95
    for share, stretches in ((0.99, False), (1.01, True)):
        motion = Trajectory(times, HOME + share / ratio * way, share / ratio * hasty.velocities)
        assert (motion.velocities <= limit).all()
        monkeypatch.setattr("tamp.world.timing.time_parametrization.smoothed", lambda *_, motion=motion: motion)
        found = time_path(np.array([HOME, HOME + 0.1]), replace(PANDA, acceleration=[1e3] * 7))
        assert (found.duration > motion.duration) == stretches
