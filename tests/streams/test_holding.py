import numpy as np
import pytest

from tamp.streams.holding import FIRM, LOST, looseness, second_best
from tamp.streams.values import Grasp
from tamp.task import Box, Object, Pose
from tests.streams.tables import workspace_of

WORKSPACE = workspace_of(Object("board", Box((0.1, 0.01, 0.1)), Pose((0.0, 0.1, 0.05)), mass=0.1, friction=0.5))
PLACE = WORKSPACE.start["board"]


def slanted(angle):
    """A grasp of the board whose pads are slanted by an angle, so that the board turns by about as much."""
    return Grasp(Pose.from_rpy((0, 0, 0.03), (np.pi + angle, 0, 0)), 0.01)


def offered(loose=(), partly=()):
    found = second_best(WORKSPACE, "board", PLACE, [(angle, slanted(angle)) for angle in loose], partly)
    return [grasp for grasp in found if grasp is not None]


def test_grasps_in_which_it_turns_a_little_come_before_those_in_which_it_turns_more():
    assert offered(loose=[0.3, 0.2, 0.4]) == [slanted(0.2), slanted(0.3), slanted(0.4)]


def test_firm_grasps_of_one_place_alternate_with_loose_ones_of_all():
    firm = [Grasp(Pose.from_rpy((x, 0, 0.03), (np.pi, 0, 0)), 0.01) for x in (0.0, 0.01)]
    assert offered(loose=[0.2, 0.3], partly=firm) == [slanted(0.2), firm[0], slanted(0.3), firm[1]]


def test_grasps_that_are_neither_firm_nor_serve_all_places_come_last():
    assert offered(loose=[0.3], partly=[slanted(0.2)]) == [slanted(0.3), slanted(0.2)]


def test_grasps_that_would_lose_the_object_are_not_offered():
    assert looseness(WORKSPACE, "board", slanted(0.65), PLACE.pose) > LOST
    assert offered(loose=[0.65], partly=[slanted(0.65)]) == []


@pytest.mark.parametrize("angle", [0.2, 0.4])
def test_a_slant_is_no_firm_grasp(angle):
    assert FIRM < looseness(WORKSPACE, "board", slanted(angle), PLACE.pose) < LOST
