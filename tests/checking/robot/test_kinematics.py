"""The checker's forward kinematics against Pinocchio's, which it must not use itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.checking.robot.kinematics import read_kinematics
from tamp.errors import RobotError
from tamp.task import RobotSpec, load_robot


def test_every_link_is_where_pinocchio_has_it() -> None:
    pinocchio = pytest.importorskip("pinocchio")
    spec = load_robot("panda")
    model = pinocchio.buildModelFromUrdf(str(spec.urdf))
    data = model.createData()
    rng = np.random.default_rng(0)
    q = rng.uniform(spec.lower, spec.upper, size=(50, 7))
    placed = read_kinematics(spec).forward(q, 0.05)
    for i, row in enumerate(q):
        full = np.zeros(model.nq)
        for name, value in zip((*spec.joints, *spec.gripper.joints), (*row, 0.025, 0.025), strict=True):
            full[model.joints[model.getJointId(name)].idx_q] = value
        pinocchio.framesForwardKinematics(model, data, full)
        for link in placed:
            T = spec.T_world_base.matrix @ data.oMf[model.getFrameId(link)].homogeneous
            assert np.allclose(placed[link][i], T, atol=1e-9), link


def test_the_tool_stands_between_the_fingers() -> None:
    spec = load_robot("panda")
    tree = read_kinematics(spec)
    q = np.array([spec.home])
    placed = tree.forward(q, 0.06)
    left, right = (placed[name][0, :3, 3] for name in spec.gripper.fingers)
    assert np.linalg.norm(left - right) == pytest.approx(0.06)
    T = tree.tool(q)[0]
    between = np.linalg.inv(T) @ np.append((left + right) / 2, 1.0)
    assert np.allclose(between[:2], 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("not xml", "cannot read"),
        ("<robot/>", "root link"),
        ('<robot><link name="a"/><link name="b"/></robot>', "root link"),
        ('<robot><link name="a"/></robot>', "panda_joint1"),
        ('<robot><link name="a"/><joint name="j" type="fixed"/></robot>', "'j' lacks"),
    ],
)
def test_a_broken_description_is_refused(text: str, named: str) -> None:
    spec: RobotSpec = replace(load_robot("panda"), description=text)
    with pytest.raises(RobotError, match=named):
        read_kinematics(spec)
