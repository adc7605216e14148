import pytest

from tamp.task import load_robot
from tamp.world.robot.model import robot_model


@pytest.fixture(scope="session")
def panda():
    return robot_model(load_robot("panda"))
