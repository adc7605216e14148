from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tamp.task import RobotSpec, load_robot
from tamp.world.kinematics import levenberg_marquardt as method
from tamp.world.robot.chain import chain
from tamp.world.robot.model import RobotModel, robot_model


@pytest.fixture(scope="module")
def panda() -> RobotModel:
    spec: RobotSpec = load_robot("panda")
    return robot_model(spec)


def linearized(robot: RobotModel, q: Any, goal: Any) -> tuple[Any, Any]:
    """What is missing to a goal at a configuration, (6,), and the Jacobian there, (6, n)."""
    arm = chain(robot)
    frames, error, jacobian = np.zeros((robot.dof + 1, 3, 4)), np.empty(6), np.empty((6, robot.dof))
    frames[0] = np.eye(4)[:3]
    method._linearize((arm.turn, arm.offset, arm.axis, arm.slides, arm.tool), q, goal, frames, error, jacobian)
    return error, jacobian


def test_the_error_is_none_at_the_goal_and_the_jacobian_agrees_with_differences(panda: RobotModel) -> None:
    rng = np.random.default_rng(0)
    for q in rng.uniform(panda.lower, panda.upper, (20, panda.dof)):
        step = 1e-6 * rng.normal(size=panda.dof)
        error, jacobian = linearized(panda, q, panda.forward(q))
        np.testing.assert_allclose(error, 0.0, atol=1e-9)
        missing, _ = linearized(panda, q, panda.forward(q + step))
        np.testing.assert_allclose(missing, jacobian @ step, atol=1e-9)


def test_many_goals_take_each_their_own_start(panda: RobotModel) -> None:
    rng = np.random.default_rng(1)
    wanted = rng.uniform(panda.lower, panda.upper, (10, panda.dof))
    goals = np.array([panda.forward(q) for q in wanted])
    starts = wanted + 0.05 * rng.normal(size=wanted.shape)
    q, residual = method.levenberg_marquardt(panda, starts, goals, patience=10)
    assert (residual == 0.0).any()
    for found, goal in zip(q[residual == 0.0], goals[residual == 0.0], strict=True):
        np.testing.assert_allclose(panda.forward(found), goal, atol=1e-5)
