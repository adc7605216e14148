from __future__ import annotations

import math

import numpy as np
import pytest

from tamp.streams.affordances.tilts import tilts
from tamp.streams.releasing.edge_contact import (
    CARRYING,
    dragged,
    held_up,
    hooked,
    turned_off,
)
from tamp.streams.values import Grasp, Placement
from tamp.task import At, Box, Mesh, Object, Pose
from tests.streams.tables import OBJECTS, workspace_of

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
    answers = [is_dragged(workspace, degrees, on) for degrees in range(10, 50, 10)]
    assert answers == sorted(answers, reverse=True)


def test_fingers_beside_a_book_do_not_carry_it(workspace):
    assert not is_dragged(workspace, 10, "smooth", grasp=ACROSS)


def test_nor_does_a_hand_at_the_side_that_is_down(workspace):
    assert not is_dragged(workspace, 10, "smooth", rising=(-1.0, 0.0))


@pytest.mark.parametrize(("aside", "expected"), [(0.0, False), (0.03, False), (0.045, True), (-0.045, True)])
def test_what_is_held_beside_the_plane_of_its_fall_turns_off_the_finger_beneath_it(workspace, aside, expected):
    place = Placement(BOOK.goal.pose, ("table",))
    falls = [tilt.fall for tilt in tilts(workspace, "book", place) if round(np.degrees(tilt.angle)) == 20]
    (tilted,) = (fall[0] for fall in falls if np.allclose(fall[0].matrix[:2, 2], (-np.sin(np.radians(20)), 0.0)))
    for T, turns in ((T_BEYOND, expected), (T_ACROSS, False)):
        T_aside = T + np.outer([0, aside, 0, 0], [0, 0, 0, 1])
        grasp = Grasp(Pose.from_matrix(T_aside), BEYOND.width)
        assert turned_off(workspace, "book", place, grasp, tilted) == turns


BOWL = Object("bowl", Mesh(OBJECTS / "bowl" / "collision.obj"), Pose((0.1, 0.2, 0.0275)), At(Pose((0.1, -0.2, 0.0275))))

# At its rim towards +x, along the wall that slopes by 33 degrees from upright: one finger inside, the other outside.
SLOPE = math.radians(33.0)
ALONG, THROUGH = (-math.sin(SLOPE), 0.0, -math.cos(SLOPE)), (-math.cos(SLOPE), 0.0, math.sin(SLOPE))
T_RIM = np.column_stack([np.cross(THROUGH, ALONG), THROUGH, ALONG, (0.066, 0.0, 0.008)])
RIM = Grasp(Pose.from_matrix(np.vstack([T_RIM, (0, 0, 0, 1)])), 0.005)


@pytest.fixture(scope="module")
def bowls():
    return workspace_of(BOWL)


def bowl_hangs(bowls, side):
    """How far the closing axis leans and whether the bowl hangs, by tilt: its rim rises at the hand (1), or across."""
    falls = [tilt.fall for tilt in tilts(bowls, "bowl", Placement(BOWL.goal.pose, ("table",)))]  # the least first
    there = [fall for fall in falls if side * -fall[0].matrix[0, 2] > 0.9 * np.hypot(*fall[0].matrix[:2, 2])]
    leans = [abs(float(fall[0].matrix[2, :3] @ THROUGH)) for fall in there]
    return leans, [hooked(bowls, "bowl", RIM, fall) for fall in there]


def test_a_bowl_that_turns_over_its_edge_hangs_on_the_finger_inside_it_but_on_none_beside_it(bowls):
    leans, answers = bowl_hangs(bowls, 1)
    assert answers == [lean >= CARRYING for lean in leans]
    assert set(answers) == {False, True}


def test_at_the_side_that_is_down_it_does_from_a_tilt_on(bowls):
    _, answers = bowl_hangs(bowls, -1)
    assert answers == sorted(answers)
    assert set(answers) == {False, True}


def test_fingers_that_are_passed_once_stop_nothing(bowls):
    start, lower = BOWL.pose, Pose((0.1, 0.2, -0.2))
    met = Pose((0.1 + 0.015, 0.2, 0.0275))  # a finger's room, and more, aside
    assert not hooked(bowls, "bowl", RIM, (start, lower))
    assert not hooked(bowls, "bowl", RIM, (start, met, lower))
    assert hooked(bowls, "bowl", RIM, (start, met, met, lower))


def test_what_lies_on_a_finger_beneath_it_does_not_hang(workspace):
    for tilt in tilts(workspace, "book", Placement(BOOK.goal.pose, ("rough",))):
        assert not hooked(workspace, "book", BEYOND, tilt.fall)


LYING = Pose.from_rpy((0.10, -0.15, 0.0341), (0.0, np.pi / 2, 0.0))
BLOCK = Object("block", Box((0.06, 0.10, 0.07)), Pose((0.05, 0.20, 0.035)), At(LYING))
CRATE = Object("crate", Mesh(OBJECTS / "open_box" / "collision.obj", scale=0.6), Pose((0.10, -0.15, 0.018)))
SHELF = Object("shelf", Box((0.3, 0.3, 0.02)), Pose((0.10, -0.15, -0.0065)))


@pytest.fixture(scope="module")
def rimmed():
    return workspace_of(BLOCK, CRATE, SHELF)


def held(rimmed, name):
    """Tilts from which the block would be held up [degrees], and those from which it falls."""
    place, below = Placement(LYING, (name,)), {name: rimmed.start[name]}
    found = {True: set(), False: set()}
    for tilt in tilts(rimmed, "block", place):
        found[held_up(rimmed, "block", tilt.fall, below)].add(round(np.degrees(tilt.angle)))
    return found[True], found[False]


def test_nothing_is_held_up_on_a_flat_support(rimmed):
    assert held(rimmed, "shelf")[0] == set()


def test_nor_is_what_leans_on_a_rim_and_stands_on_its_lowest_edge(rimmed):
    assert held(rimmed, "crate")[0] == set()


@pytest.mark.parametrize(("tilt", "up"), [(0.2, False), (0.9, True)])
def test_what_is_carried_above_its_lowest_edge_only_is_held_up_if_it_would_slide_far_there(tilt, up):
    edge, flat = Pose((-0.03, 0.0, 0.04)), Pose((0.03, 0.0, 0.005))
    height = 0.04 + 0.03 * math.tan(tilt)
    wall = Object("wall", Box((0.004, 0.1, height)), Pose((0.0, 0.0, height / 2)))
    bench = workspace_of(wall, Object("plank", Box((0.06, 0.12, 0.01)), Pose((0.2, 0.2, 0.005))))
    fall = edge @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, -tilt, 0.0)) @ flat, edge @ flat
    assert held_up(bench, "plank", fall, {"wall": bench.start["wall"]}) == up


def test_what_touches_nothing_is_not_held_up(rimmed):
    fall = (Pose.from_rpy((0.1, 0.2, 0.5), (0.3, 0.0, 0.0)), Pose((0.1, 0.2, 0.45)))
    assert not held_up(rimmed, "block", fall, {"crate": rimmed.start["crate"]})
