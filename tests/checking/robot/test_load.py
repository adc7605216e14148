from __future__ import annotations

import numpy as np
import pytest

from tamp.checking.robot.kinematics import read_kinematics
from tamp.checking.robot.load import overloaded
from tamp.task import load_robot


@pytest.mark.parametrize(("seed", "weight"), [(0, 20.0), (1, 60.0), (2, 200.0)])
def test_a_joint_bears_what_lifting_takes_by_virtual_work(seed, weight):
    spec = load_robot("panda")
    tree = read_kinematics(spec)
    q = np.random.default_rng(seed).uniform(spec.lower, spec.upper)
    by = 1e-5 * np.eye(len(q))
    torques = weight * np.abs(tree.tool(q + by)[:, 2, 3] - tree.tool(q - by)[:, 2, 3]) / 2e-5
    efforts = [joint.effort for joint in tree.joints if joint.name in spec.joints]
    assert efforts == [87.0] * 4 + [12.0] * 3
    found = overloaded(tree, q[None], tree.tool(q[None])[:, :3, 3], np.array([0.0, 0.0, -weight]))
    shares = torques / efforts
    assert (found is not None) == (shares.max() > 1.0)
    if found is not None:
        assert f"asks {torques[shares.argmax()]:.0f} N m of {spec.joints[shares.argmax()]}" in found[1]
