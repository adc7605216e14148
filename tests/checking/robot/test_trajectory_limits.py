"""Limits of trajectories: what a joint can do passes, what it cannot is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.robot.cubic import interpolate
from tamp.checking.robot.trajectory_limits import malformed, violations
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


def ramped(share: float, step: float) -> Trajectory:
    """The same with accelerations that change at the limit of jerk."""
    a, half = share * SPEC.acceleration[0], 0.1
    ramp = 2 * a / SPEC.jerk[0]
    turns = np.array([0.0, ramp, half, half + ramp, 2 * half, 2 * half + ramp])
    times = np.unique(np.concatenate([turns, np.arange(0.0, turns[-1], step)]))
    times = times[np.concatenate([[True], (np.diff(times) > 1e-6)])]
    h, rising = np.diff(times), np.interp(times, turns, [0.0, a, a, -a, -a, 0.0])
    v = np.concatenate([[0.0], np.cumsum(h * (rising[:-1] + rising[1:]) / 2)])
    q = np.concatenate([[0.0], np.cumsum(h * v[:-1] + h**2 * (2 * rising[:-1] + rising[1:]) / 6)])
    positions = np.tile(SPEC.home, (len(times), 1)).astype(float)
    velocities = np.zeros_like(positions)
    positions[:, 0] += q
    velocities[:, 0] = v
    return Trajectory(times, positions, velocities)


@given(step=st.floats(0.003, 0.05), share=st.floats(0.1, 1.0))
@settings(max_examples=60, deadline=None)
def test_what_the_limits_allow_passes_however_it_is_sampled(step: float, share: float) -> None:
    assert list(violations(ramped(share, step), SPEC, DEFAULT)) == []


@given(step=st.floats(0.003, 0.05), share=st.floats(0.3, 1.0))
@settings(max_examples=30, deadline=None)
def test_accelerations_that_jump_between_spans_are_named(step: float, share: float) -> None:
    ((_, sentence),) = violations(bang_bang(share, step), SPEC, DEFAULT)
    assert "panda_joint1 exceeds its jerk limit" in sentence
    assert "where spans meet" in sentence


def test_jumps_that_follow_each_other_at_once_count_together() -> None:
    def stairs(step: float) -> list[str]:
        """Steps up and down again, each but a third of what may come within a millisecond."""
        jump = SPEC.jerk[0] * 1e-3 / 3
        rising = jump * np.array([0, 1, 2, 3, 4, 3, 2, 1, 0, -1, -2, -3, -4, -3, -2, -1, 0.0])
        times = step * np.arange(len(rising) + 1)
        v = np.concatenate([[0.0], np.cumsum(step * rising)])
        positions = np.tile(SPEC.home, (len(times), 1)).astype(float)
        velocities = np.zeros_like(positions)
        positions[1:, 0] += np.cumsum(step * (v[:-1] + v[1:]) / 2)
        velocities[:, 0] = v
        return [sentence for _, sentence in violations(Trajectory(times, positions, velocities), SPEC, DEFAULT)]

    assert stairs(1.1e-3) == []
    assert any("where spans meet" in sentence for sentence in stairs(2.4e-4))


@pytest.mark.parametrize("what", ["positions", "velocities"])
def test_what_is_not_a_number_hides_no_violation(what: str) -> None:
    motion = bang_bang(3.0, 0.01)
    array = getattr(motion, what).copy()
    array[3, 2] = np.nan
    broken = replace(motion, **{what: array})
    assert "not finite" in (malformed(broken, SPEC) or "")
    text = " ".join(sentence for _, sentence in violations(broken, SPEC, DEFAULT))
    assert "acceleration limit by nan" in text
    assert "jerk limit by nan" in text
    assert "velocity limit by nan" in text


@pytest.mark.parametrize("limit", ["velocity", "acceleration", "jerk"])
def test_a_limit_that_is_not_a_number_allows_nothing(limit: str) -> None:
    spec = replace(SPEC, **{limit: (float("nan"), *getattr(SPEC, limit)[1:])})
    assert any(f"{limit} limit by nan" in s for _, s in violations(ramped(0.5, 0.01), spec, DEFAULT))


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
