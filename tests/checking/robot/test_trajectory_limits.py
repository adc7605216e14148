"""Limits of trajectories: what a joint can do passes, what it cannot is named."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.robot.trajectory_limits import interpolate, malformed, violations
from tamp.checking.tolerances import DEFAULT
from tamp.task import Trajectory, load_robot

SPEC = load_robot("panda")


def bang_bang(share: float, step: float) -> Trajectory:
    """Joint 1 at full acceleration, then full braking, sampled about every `step` [s] and where it turns."""
    a, half = share * SPEC.acceleration[0], 0.1
    times = np.linspace(0.0, 2 * half, 2 * int(np.ceil(half / step)) + 1)
    up = times < half
    v = np.where(up, a * times, a * (2 * half - times))
    q = np.where(up, a * times**2 / 2, a * half**2 - a * (2 * half - times) ** 2 / 2)
    positions = np.tile(SPEC.home, (len(times), 1)).astype(float)
    velocities = np.zeros_like(positions)
    positions[:, 0] += q
    velocities[:, 0] = v
    return Trajectory(times, positions, velocities)


@given(step=st.floats(0.003, 0.05), share=st.floats(0.1, 1.0))
@settings(max_examples=60, deadline=None)
def test_what_the_limits_allow_passes_however_it_is_sampled(step: float, share: float) -> None:
    assert list(violations(bang_bang(share, step), SPEC, DEFAULT)) == []


@given(step=st.floats(0.003, 0.05), share=st.floats(1.05, 1.4))
@settings(max_examples=60, deadline=None)
def test_too_much_acceleration_is_named(step: float, share: float) -> None:
    text = " ".join(sentence for _, sentence in violations(bang_bang(share, step), SPEC, DEFAULT))
    assert "panda_joint1" in text
    assert "acceleration" in text


@given(step=st.floats(0.005, 0.05))
@settings(max_examples=30, deadline=None)
def test_a_cubic_that_turns_within_a_span_exceeds_the_limit_between_samples(step: float) -> None:
    a = SPEC.acceleration[0]
    positions = np.tile(SPEC.home, (3, 1)).astype(float)
    positions[1, 0] += a * step**2 / 4  # up and down again within the span: rest at both ends of it
    positions[2, 0] = positions[1, 0]
    motion = Trajectory(np.array([0.0, step, 2 * step]), positions, np.zeros_like(positions))
    assert any("acceleration limit by 50" in sentence for _, sentence in violations(motion, SPEC, DEFAULT))


def test_jerk_between_samples_is_named() -> None:
    step = 1e-4
    positions = np.tile(SPEC.home, (3, 1)).astype(float)
    velocities = np.zeros_like(positions)
    velocities[1, 0] = SPEC.acceleration[0] * step / 2
    positions[1:, 0] += np.array([1, 2]) * velocities[1, 0] * step / 3
    motion = Trajectory(np.array([0.0, step, 2 * step]), positions, velocities)
    assert any("jerk limit" in sentence for _, sentence in violations(motion, SPEC, DEFAULT))


def test_a_curve_that_overshoots_a_position_limit_between_samples() -> None:
    positions = np.tile(SPEC.home, (3, 1)).astype(float)
    positions[:, 6] = [SPEC.upper[6] - 0.3, SPEC.upper[6] - 0.001, SPEC.upper[6] - 0.3]
    velocities = np.zeros_like(positions)
    velocities[1, 6] = 2.0
    found = [s for _, s in violations(Trajectory(np.array([0.0, 0.3, 0.6]), positions, velocities), SPEC, DEFAULT)]
    assert any("position limits" in sentence and "panda_joint7" in sentence for sentence in found)


def test_the_cubic_goes_through_its_samples() -> None:
    motion = bang_bang(1.0, 0.01)
    assert np.allclose(interpolate(motion, motion.times), motion.positions)
    h = 1e-6
    inner = motion.times[1:-1]
    slope = (interpolate(motion, inner + h) - interpolate(motion, inner - h)) / (2 * h)
    assert np.allclose(slope, motion.velocities[1:-1], atol=1e-4)


@pytest.mark.parametrize(
    ("times", "shape", "named"),
    [
        ([0.0], (1, 7), "at least two"),
        ([0.0, 0.0], (2, 7), "increase"),
        ([0.1, 0.2], (2, 7), "from 0"),
        ([0, 1], (2, 6), "shape"),
    ],
)
def test_malformed_arrays_are_named(times: list[float], shape: tuple[int, int], named: str) -> None:
    motion = Trajectory(np.array(times), np.zeros(shape), np.zeros(shape))
    assert named in str(malformed(motion, SPEC))


def test_numbers_that_are_not_finite_are_named() -> None:
    motion = Trajectory(np.array([0.0, 1.0]), np.full((2, 7), np.nan), np.zeros((2, 7)))
    assert "not finite" in str(malformed(motion, SPEC))
