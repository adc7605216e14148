from __future__ import annotations

import numpy as np
import pytest

from tamp.task import load_robot
from tamp.world.robot.model import robot_model
from tamp.world.robot.payload import SPARED, always_borne, overloaded

EFFORTS = np.array([87.0] * 4 + [12.0] * 3)


@pytest.fixture(scope="module")
def panda():
    return robot_model(load_robot("panda"))


@pytest.mark.parametrize(("seed", "weight"), [(0, 20.0), (1, 60.0), (2, 200.0), (3, 110.0)])
def test_a_joint_bears_what_lifting_takes_by_virtual_work(panda, seed, weight):
    q = np.random.default_rng(seed).uniform(panda.lower, panda.upper)
    by = 1e-5 * np.eye(panda.dof)
    risen = [panda.forward(q + step)[2, 3] - panda.forward(q - step)[2, 3] for step in by]
    shares = weight * np.abs(risen) / 2e-5 / EFFORTS
    found = overloaded(panda, q[None], panda.forward(q)[None, :3, 3], np.array([0.0, 0.0, -weight]))
    assert (found is not None) == (shares.max() > SPARED)
    if found is not None:
        worst = shares.argmax()
        assert f"more of {panda.spec.joints[worst]} than the {EFFORTS[worst]:.0f} N m" in found


def test_what_is_always_borne_is_borne_anywhere(panda):
    rng = np.random.default_rng(0)
    q = rng.uniform(panda.lower, panda.upper, (2000, panda.dof))
    tools = np.array([panda.forward(one) for one in q])
    points = tools[:, :3, 3] + 0.05 * tools[:, :3, 0]
    lightest = next(force for force in np.arange(1.0, 500.0) if not always_borne(panda, float(force), 0.05))
    assert lightest > 20.0
    assert overloaded(panda, q, points, np.array([0.0, 0.0, -(lightest - 1.0)])) is None
    assert overloaded(panda, q, points, np.array([0.0, 0.0, -20 * lightest])) is not None
