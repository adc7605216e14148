"""The tilt limit, held against the collision checker on configurations it was not made from."""

import numpy as np
import pytest

from tamp.task import Table
from tamp.world.kinematics.seeds import one_turn
from tamp.world.kinematics.tilt_limit import LOWEST, STEP, tilt_limit
from tamp.world.robot.chain import chain
from tamp.world.scene import Scene
from tamp.world.world import World

ENDLESS = Table(center=(0.0, 0.0), size=(8.0, 8.0))


@pytest.fixture(scope="module")
def low_tools(panda):
    """Configurations whose tools are up to 30 cm above the table, and the tools."""
    q = np.random.default_rng(5).uniform(*one_turn(panda), (20000, panda.dof))
    R, p = chain(panda).forward(q)
    T = np.tile(np.eye(4), (len(q), 1, 1))
    T[:, :3, :3], T[:, :3, 3] = R, p
    low = (p[:, 2] > 0.02) & (p[:, 2] < 0.3)
    return q[low][:2500], T[low][:2500]


def test_no_arm_that_is_above_the_table_holds_its_tool_beyond_the_limit(panda, low_tools):
    checker = World(panda, {}, ENDLESS).checker(Scene())
    q, T = low_tools
    clear = np.array([checker.free(each) for each in q])
    assert clear.sum() > 300
    assert tilt_limit(panda).keeps_arm_up(T[clear]).all()


def test_what_is_beyond_the_limit_reaches_into_the_table(panda, low_tools):
    q, T = low_tools
    beyond = ~tilt_limit(panda).keeps_arm_up(T)
    checker = World(panda, {}, ENDLESS).checker(Scene())
    assert beyond.sum() > 200
    assert not any(checker.free(each) for each in q[beyond])


def test_a_hand_may_point_up_farther_the_higher_it_is(panda):
    heights = np.arange(0.03, 0.25, STEP)
    tilts = tilt_limit(panda).tilts[((heights - LOWEST) / STEP).astype(int)]
    assert (np.diff(tilts) > -0.05).all()
    assert np.radians(80.0) < tilts[0] < np.radians(95.0) and tilts[-1] > np.radians(135.0)
