import numpy as np
import pytest

from tamp.streams.dragging import dragged
from tamp.streams.tilting import tilts
from tamp.streams.values import Grasp, Placement
from tamp.task import At, Box, Object, Pose
from tests.streams.tables import workspace_of

LENGTH, WIDTH, HEIGHT = 0.16, 0.12, 0.03
BOOK = Object("book", Box((LENGTH, WIDTH, HEIGHT)), Pose((0.1, 0.3, HEIGHT / 2)), At(Pose((0.1, -0.2, 0.1))))
ROUGH = Object("rough", Box((0.2, 0.2, 0.02)), Pose((-0.1, 0.0, 0.01)), friction=1.0)
SMOOTH = Object("smooth", Box((0.2, 0.2, 0.02)), Pose((0.1, 0.0, 0.01)), friction=0.3)

# At the side towards +x, a centimetre deep, from there, closing across the book's thickness; and closing along y.
T_BEYOND = np.array([[0, 0, -1, LENGTH / 2 - 0.01], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
T_ACROSS = np.array([[0, 0, -1, LENGTH / 2 - 0.01], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])
BEYOND, ACROSS = Grasp(Pose.from_matrix(T_BEYOND), HEIGHT), Grasp(Pose.from_matrix(T_ACROSS), 0.07)


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(BOOK, ROUGH, SMOOTH)


def is_dragged(workspace, degrees, *on, grasp=BEYOND, rising=(1.0, 0.0)):
    """Whether the book is, laid down over the edge from which it rises in a direction."""
    place = Placement(BOOK.goal.pose, on)
    falls = [tilt.fall for tilt in tilts(workspace, "book", place) if round(np.degrees(tilt.angle)) == degrees]
    (tilted,) = (
        fall[0] for fall in falls if np.allclose(-fall[0].matrix[:2, 2], np.sin(np.radians(degrees)) * np.array(rising))
    )
    return dragged(workspace, "book", place, grasp, tilted)


def test_a_book_that_lies_nearly_flat_on_something_smooth_goes_with_the_hand(workspace):
    assert is_dragged(workspace, 10, "smooth")
    assert not is_dragged(workspace, 30, "smooth")


def test_it_does_not_where_it_is_held_faster_than_by_the_finger(workspace):
    assert not is_dragged(workspace, 10, "rough")
    assert not is_dragged(workspace, 10, "table")


def test_the_smoothest_of_what_it_lies_on_counts(workspace):
    assert is_dragged(workspace, 10, "rough", "smooth")


@pytest.mark.parametrize("on", ["smooth", "rough"])
def test_whoever_is_dragged_at_a_tilt_is_so_at_every_lesser_one(workspace, on):
    answers = [is_dragged(workspace, degrees, on) for degrees in range(10, 50, 5)]
    assert answers == sorted(answers, reverse=True)


def test_fingers_beside_a_book_do_not_carry_it(workspace):
    assert not is_dragged(workspace, 10, "smooth", grasp=ACROSS)


def test_nor_does_a_hand_at_the_side_that_is_down(workspace):
    assert not is_dragged(workspace, 10, "smooth", rising=(-1.0, 0.0))
