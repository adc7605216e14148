from __future__ import annotations

import math

import numpy as np
import pytest

from tamp.execution.robot.links import robot_links
from tamp.task import load_robot
from tamp.world.robot.model import robot_model

PANDA = load_robot("panda")
LINKS = {link.name: link for link in robot_links(PANDA)}


def test_the_tree_carries_the_tool_where_the_planner_has_it():
    """Joints turned by the formula of Rodrigues, one after the other down to the tool."""
    q = dict(zip(PANDA.joints, (0.3, -0.4, 0.5, -1.9, 0.2, 1.8, 0.6), strict=True))
    chain, name = [], PANDA.tool_parent
    while name is not None:
        chain.append(LINKS[name])
        name = LINKS[name].parent
    T = np.eye(4)
    for link in reversed(chain):
        T = T @ link.pose.matrix
        if link.joint is not None and link.joint.kind == "revolute":
            x, y, z = link.joint.axis
            K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            angle = q[link.joint.name]
            T[:3, :3] = T[:3, :3] @ (np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K)
    tool = T @ PANDA.T_parent_tool.matrix
    assert tool == pytest.approx(robot_model(PANDA).forward(np.array(list(q.values()))), abs=1e-9)


def test_parents_come_first_and_joints_are_those_that_are_driven():
    names = list(LINKS)
    assert all(link.parent is None or names.index(link.parent) < names.index(link.name) for link in LINKS.values())
    driven = {link.joint.name for link in LINKS.values() if link.joint is not None and link.joint.kind != "fixed"}
    assert driven == {*PANDA.joints, *PANDA.gripper.joints}
    assert {link.joint.effort for link in LINKS.values() if link.joint and link.joint.name in PANDA.joints} == {
        87.0,
        12.0,
    }


def test_inertia_is_that_of_the_hulls_and_masses_are_the_urdf_s():
    """The URDF's own is 0.1 kg m^2 for each link, a finger of 0.1 kg included."""
    finger, base = LINKS[PANDA.gripper.fingers[0]], LINKS["panda_link0"]
    assert finger.mass == pytest.approx(0.1)
    assert base.mass == pytest.approx(2.9)
    assert max(finger.moments) < 1e-4
    for link in LINKS.values():
        if link.hulls:
            low, mid, high = sorted(link.moments)
            assert low > 0 and high <= low + mid + 1e-12
            points = np.vstack([hull.vertices for hull in link.hulls])
            assert (points.min(axis=0) < link.frame.xyz).all() and (link.frame.xyz < points.max(axis=0)).all()
