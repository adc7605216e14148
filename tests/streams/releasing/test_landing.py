"""Falls are aimed where simulation says that they land, and refused where they land otherwise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tamp.execution.settling.settle import let_fall
from tamp.streams.affordances.tilts import tilts
from tamp.streams.releasing import landing
from tamp.streams.releasing.landing import NEAR, aimed, sure_on_table
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE
from tamp.task import Box, Object, Pose
from tests.streams.tables import workspace_of

BOARD = Object("board", Box((0.16, 0.12, 0.03)), Pose((0.1, 0.25, 0.015)))
SMOOTH = Object("smooth", Box((0.3, 0.3, 0.04)), Pose((0.05, -0.1, 0.02)), friction=0.2)
POST = Object("post", Box((0.02, 0.02, 0.04)), Pose((-0.1, -0.1, 0.02)))


@pytest.fixture(scope="module")
def table():
    return workspace_of(BOARD, SMOOTH, POST)


@pytest.mark.parametrize(("on", "height"), [(TABLE, 0.016), ("smooth", 0.056)])
def test_what_is_let_go_where_it_was_aimed_lands_at_its_placement(table, on, height):
    place = Placement(Pose((0.05, -0.1 if on == "smooth" else 0.25, height)), (on,))
    below = {} if on == TABLE else {on: table.start[on].pose}
    found = [fall for tilt in tilts(table, "board", place) if (fall := aimed(table, "board", place, tilt.fall))]
    assert found
    for fall in found:
        assert fall[-1] == place.pose
        bodies = [thing for thing in table.task.objects if thing.name == "board" or thing.name in below]
        ends = let_fall(bodies, {**below, "board": fall[0]}, table=table.task.table)
        assert math.dist(ends["board"].xyz, place.pose.xyz) < 2 * NEAR
        assert ends["board"].matrix[2, 2] > math.cos(0.1)


def test_the_edge_skids_on_what_is_smooth_and_is_let_go_as_far_to_the_other_side(table):
    place = Placement(Pose((0.05, -0.1, 0.056)), ("smooth",))
    shifts = []
    for tilt in tilts(table, "board", place):
        fall = aimed(table, "board", place, tilt.fall)
        if fall is not None:
            up = tilt.fall[0].matrix[:2, 2]  # away from the side that is up
            shifts.append(-float(np.subtract(fall[0].xyz, tilt.fall[0].xyz)[:2] @ up))
    assert max(shifts) > 0.002


def test_nothing_is_let_go_that_falls_off_what_it_shall_lie_on(table):
    place = Placement(Pose((-0.03, -0.1, 0.056)), ("post",))  # its middle is beside the post
    assert not [tilt for tilt in tilts(table, "board", place) if aimed(table, "board", place, tilt.fall)]


def test_what_misses_a_small_support_at_first_is_aimed_anew():
    stand = Object("stand", Box((0.12, 0.08, 0.04)), Pose((0.05, -0.1, 0.02)))
    slim = Object("board", Box((0.16, 0.09, 0.03)), Pose((0.1, 0.25, 0.015)))
    narrow, place = workspace_of(slim, stand), Placement(Pose((0.05, -0.1, 0.056)), ("stand",))

    def end(fall):
        poses = {"stand": stand.pose, "board": fall[0]}
        return (let_fall(narrow.task.objects, poses, table=narrow.task.table) or {}).get("board")

    def lands(fall):
        there = None if fall is None else end(fall)
        return there is not None and landing._is_at(there, place.pose)

    falls = [tilt.fall for tilt in tilts(narrow, "board", place)]
    once = [fall for fall in falls if (there := end(fall)) is not None and lands(landing._against(fall, there))]
    found = [aim for fall in falls if (aim := aimed(narrow, "board", place, fall))]
    assert all(map(lands, found))
    assert len(once) < len(found)


def test_the_same_is_aimed_alike_by_whoever_asks(table):
    place = Placement(Pose((0.05, 0.25, 0.016)), (TABLE,))
    fall = tilts(table, "board", place)[-1].fall
    assert aimed(table, "board", place, fall) == aimed(workspace_of(BOARD, SMOOTH, POST), "board", place, fall)


def test_a_board_lands_surely_from_small_tilts_but_not_from_its_edge(table):
    place = Placement(Pose((0.05, 0.25, 0.016)), (TABLE,))
    falls = [fall for tilt in tilts(table, "board", place) if (fall := aimed(table, "board", place, tilt.fall))]
    assert sure_on_table(table, "board", falls[0])
    leaning = Pose.from_rpy((0.1, 0.25, 0.08), (0.0, np.pi / 2, 0.0))  # on edge: it falls to either side
    assert not sure_on_table(table, "board", (leaning, place.pose))
