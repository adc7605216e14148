from __future__ import annotations

import dataclasses
from xml.etree import ElementTree

import numpy as np
import pytest

from tamp.errors import RobotError
from tamp.task import Pose, load_robot
from tamp.world.robot.chain import chain
from tamp.world.robot.model import robot_model
from tamp.world.robot.urdf import link_shapes

ROBOT = """<robot name="r">
  <link name="base"/>
  <joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>LIMIT</joint>
  <link name="arm"><collision><geometry>SHAPE</geometry></collision></link>
</robot>"""
LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def test_the_tool_of_the_panda_at_home(panda):
    T = panda.forward(panda.home)
    np.testing.assert_allclose(T[:3, 2], (0, 0, -1), atol=1e-9)
    np.testing.assert_allclose(T[:3, 3], (-0.42 + 0.5545, 0, 0.002 + 0.5211), atol=1e-3)


def test_every_link_has_a_hull_with_volume(panda):
    names = [body.name for body in panda.bodies]
    assert names[0] == "panda_link0"
    assert {"panda_link6", "panda_hand", "panda_leftfinger", "panda_rightfinger"} <= set(names)
    assert [names[i] for i in panda.hand] == ["panda_hand", "panda_leftfinger", "panda_rightfinger"]


def test_a_robot_of_which_nothing_but_the_hand_has_hulls_has_no_pairs():
    spec = load_robot("panda")
    root = ElementTree.fromstring(spec.description)
    for link in root.findall("link"):
        if "finger" not in link.get("name", ""):
            for collision in link.findall("collision"):
                link.remove(collision)
    bare = dataclasses.replace(spec, description=ElementTree.tostring(root, encoding="unicode"))
    assert robot_model(bare).pairs == ()


def test_self_collision_pairs_leave_out_neighbours_and_keep_what_folds(panda):
    names = [(panda.bodies[a].name, panda.bodies[b].name) for a, b in panda.pairs]
    assert ("panda_link0", "panda_hand") in names
    assert ("panda_link5", "panda_hand") in names
    assert ("panda_link6", "panda_link7") not in names
    assert ("panda_leftfinger", "panda_rightfinger") not in names


def test_the_base_may_stand_anywhere(panda):
    moved = robot_model(dataclasses.replace(panda.spec, T_world_base=Pose.from_rpy((1, 2, 3), (0, 0, np.pi))))
    T_base = panda.spec.T_world_base.matrix
    expected = moved.spec.T_world_base.matrix @ np.linalg.inv(T_base) @ panda.forward(panda.home)
    np.testing.assert_allclose(moved.forward(moved.home), expected, atol=1e-9)


def test_the_chain_agrees_with_pinocchio(panda):
    q = np.random.default_rng(0).uniform(panda.lower, panda.upper, (20, panda.dof))
    for T, R, p in zip(map(panda.forward, q), *chain(panda).forward(q), strict=True):
        np.testing.assert_allclose(T[:3, :3], R, atol=1e-12)
        np.testing.assert_allclose(T[:3, 3], p, atol=1e-12)


@pytest.mark.parametrize(
    ("shape", "complaint"),
    [
        ('<mesh filename="/nowhere/absent.stl"/>', r"link 'arm': .*absent\.stl: no such mesh file"),
        ("<torus/>", "geometry <torus>; valid are mesh, box, cylinder, sphere and capsule"),
        ("", "a <collision> without geometry"),
    ],
)
def test_unusable_geometry_is_refused_in_one_sentence(shape, complaint):
    description = ROBOT.replace("LIMIT", LIMIT).replace("SHAPE", shape)
    spec = dataclasses.replace(load_robot("panda"), description=description)
    with pytest.raises(RobotError, match=complaint) as error:
        link_shapes(spec)
    assert str(spec.urdf) in str(error.value)
    assert "\n" not in str(error.value)


def test_a_joint_that_came_to_rest_a_hair_beyond_its_limit_is_taken_to_stand_there(panda):
    q = panda.home.copy()
    q[0] = panda.upper[0] + 0.001
    assert panda.overshot(q)[0] == panda.upper[0]
    assert np.array_equal(panda.overshot(q)[1:], q[1:])
    q[0] = panda.upper[0] + 0.1  # who says so is told
    assert np.array_equal(panda.overshot(q), q)
