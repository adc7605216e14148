"""What is carried within a tolerance only, and by nothing that it really touches, does not stay."""

from __future__ import annotations

import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.actions.left_standing import check_rest, check_uncovered
from tamp.task import Box, Mesh, Object, Pose
from tests.checking.physics.heaps import PUT_ON_LITTLE, TAKEN_FROM_LITTLE, said, turned


@pytest.mark.parametrize("title", PUT_ON_LITTLE)
def test_what_does_not_rest_on_what_it_first_touches_does_not_stay(title):
    assert said(check_rest, PUT_ON_LITTLE[title])


@pytest.mark.parametrize("title", TAKEN_FROM_LITTLE)
def test_what_is_left_with_less_than_it_needs_gives_way(title):
    assert said(check_uncovered, TAKEN_FROM_LITTLE[title])


@given(yaw=st.floats(-3.0, 3.0), beyond=st.floats(0.0025, 0.0045), gap=st.floats(0.0, 4e-4))
@settings(max_examples=25, deadline=None)
def test_nothing_stands_beside_an_edge_that_it_barely_overlaps(yaw, beyond, gap):
    column = Object("column", Box((0.04, 0.06, 0.1)), Pose((0.0, 0.0, 0.05)), mass=0.4)
    domino = Object("it", Box((0.0095, 0.06, 0.14)), Pose((0.02 + beyond, 0.0, 0.17 + gap)), friction=0.8)
    assert said(check_rest, turned((column, domino), yaw))


@given(yaw=st.floats(-3.0, 3.0), gap=st.floats(0.0, 0.0028), aside=st.floats(0.0, 0.022))
@settings(max_examples=25, deadline=None)
def test_what_stands_level_stays_however_it_comes_down(yaw, gap, aside):
    block = Object("block", Box((0.06, 0.06, 0.05)), Pose((0.0, 0.0, 0.025)))
    box = Object("it", Box((0.05, 0.05, 0.05)), Pose((aside, 0.0, 0.075 + gap)))
    assert not said(check_rest, turned((block, box), yaw))


def test_what_pieces_that_bulge_carry_is_not_said_to_tip_over_the_first_of_them(tmp_path):
    """As a banana on two rims of a crate: of the lower one nobody knows within millimetres how high it is."""
    path, lines = tmp_path / "rims.obj", list[str]()
    for number, (x, top) in enumerate(((-0.01, 0.1), (0.01, 0.0975))):
        wall = trimesh.creation.box((0.004, 0.2, top))
        wall.apply_translation((x, 0.0, top / 2))
        lines += [f"o rim{number}", *("v {:.6f} {:.6f} {:.6f}".format(*v) for v in wall.vertices)]
        lines += ["f {} {} {}".format(*(face + 1 + 8 * number)) for face in wall.faces]
    path.write_text("\n".join(lines))
    rims = Object("rims", Mesh(path), Pose((0.0, 0.0, 0.0)), mass=2.0)
    board = Object("it", Box((0.4, 0.4, 0.02)), Pose((0.003, 0.0, 0.11)))
    assert not any("first touches" in sentence for sentence in said(check_rest, (rims, board)))
