import numpy as np
import pytest

from tamp.streams.facing import facing, put_down
from tamp.streams.footing import amid, resting
from tamp.streams.values import Grasp
from tamp.task import Box, Object, Pose
from tests.streams.tables import workspace_of

BOOK = Object("book", Box((0.04, 0.17, 0.26)), Pose((0.0, 0.2, 0.13)))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(BOOK)


def test_it_stays_turned_as_it_stands_first(workspace):
    R = facing(workspace, "book", np.random.default_rng(0), 0)
    assert np.allclose(R, np.eye(3))


def test_of_what_will_do_some_is_drawn_and_of_all_where_nothing_does(workspace):
    rng = np.random.default_rng(0)
    lying = [facing(workspace, "book", rng, draw, lambda R: abs(R[2, 0]) > 0.9) for draw in range(8)]
    assert all(abs(R[2, 0]) > 0.9 for R in lying)
    assert np.allclose(facing(workspace, "book", rng, 0, lambda R: False), np.eye(3))


def test_no_hand_puts_it_down_on_its_wide_side_whatever_its_grasp(workspace):
    flat = [R for R in resting(workspace, "book") if abs(R[2, 0]) > 0.9]
    assert flat
    assert not any(put_down(workspace, "book", None, R) for R in flat)
    assert all(put_down(workspace, "book", None, R) for R in resting(workspace, "book") if abs(R[2, 0]) < 0.1)


def test_the_hand_that_holds_it_at_one_end_does_not_set_that_end_down(workspace):
    from_above = Grasp(Pose.from_rpy((0.0, 0.0, 0.12), (np.pi, 0.0, np.pi / 2)), 0.04)
    upside_down = np.diag([1.0, -1.0, -1.0])
    assert put_down(workspace, "book", from_above, np.eye(3))
    assert not put_down(workspace, "book", from_above, upside_down)
    assert amid(workspace, "book", upside_down).on == ("table",)
