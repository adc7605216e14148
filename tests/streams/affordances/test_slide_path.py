from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams.affordances.slide_path import (
    FIRM,
    STEADY,
    _sides,
    directions,
    edges,
    shifted,
    slidable,
    stands,
    ways,
    ways_to,
)
from tamp.streams.affordances.stable_poses import inside_by, outline
from tamp.streams.values import Placement
from tamp.task import Box, Cylinder, Mesh, Object, Pose
from tamp.task.mesh.parts import convex_hull
from tests.streams.tables import corners, workspace_of
from tests.task.meshes import parts_obj

PLATE = (
    Path(__file__).resolve().parents[4] / "shared" / "ocrtoc" / "2021" / "models" / "round_plate_4" / "collision.obj"
)
FLAT = Object("flat", Box((0.17, 0.11, 0.045)), Pose.from_rpy((-0.05, -0.35, 0.0225), (0.0, 0.0, 0.3)))
NARROW = Object("narrow", Box((0.17, 0.07, 0.045)), Pose((0.1, 0.0, 0.0225)))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(FLAT, NARROW)


def test_only_what_lies_wider_than_the_hand_opens_is_slid(workspace):
    assert slidable(workspace, "flat", workspace.start["flat"])
    assert not slidable(workspace, "narrow", workspace.start["narrow"])


def test_what_stands_on_its_edge_is_gripped_as_it_stands(workspace):
    upright = Placement(Pose.from_rpy((0.1, 0.1, 0.055), (np.pi / 2, 0.0, 0.0)), ("table",))
    assert not slidable(workspace, "flat", upright)


def test_what_stands_on_other_things_is_not_slid(workspace):
    assert not slidable(workspace, "flat", replace(workspace.start["flat"], on=("narrow",)))


def test_what_hangs_over_the_edge_already_is_gripped_there(workspace):
    (way, *_) = ways(workspace, "flat", workspace.start["flat"])
    assert not slidable(workspace, "flat", way.end)


@pytest.mark.skipif(not PLATE.exists(), reason="the models of OCRTOC 2021 are not beside the checkout")
def test_a_plate_whose_rim_would_tilt_out_of_every_hand_is_slid():
    workspace = workspace_of(Object("plate", Mesh(PLATE), Pose((0.0, 0.2, 0.012))))
    assert slidable(workspace, "plate", workspace.start["plate"])


@settings(max_examples=20, deadline=None)
@given(x=st.floats(-0.3, 0.1), y=st.floats(-0.4, 0.4), yaw=st.floats(-np.pi, np.pi))
def test_every_way_ends_over_an_edge_with_the_centre_of_mass_well_inside(workspace, x, y, yaw):
    start = Placement(Pose.from_rpy((x, y, 0.0225), (0.0, 0.0, yaw)), ("table",))
    table = workspace.task.table
    half = np.array(table.size) / 2
    for way in ways(workspace, "flat", start):
        assert way.end.pose.quat == start.pose.quat
        np.testing.assert_allclose(np.array(way.end.pose.xyz)[:2] - start.pose.xyz[:2], way.shift, atol=1e-12)
        inside = half - np.abs(np.array(way.end.pose.xyz[:2]) - table.center)
        assert inside.min() > STEADY - 1e-6
        outside = np.abs(corners(workspace, "flat", way.end.pose)[:, :2] - table.center) - half
        assert outside.max() > 0.02


CROSS = (((-0.1, -0.02, 0.0), (0.1, 0.02, 0.04)), ((-0.02, -0.1, 0.0), (0.02, 0.1, 0.04)))
"""Two beams, crossed: the outline spans far more than what lies on the table."""


@settings(max_examples=20, deadline=None)
@given(yaw=st.floats(-np.pi, np.pi))
def test_what_has_a_narrow_base_hangs_over_no_farther_than_that_carries(tmp_path_factory, yaw):
    mesh = tmp_path_factory.mktemp("cross") / "cross.obj"
    mesh.write_text(parts_obj(CROSS))
    workspace = workspace_of(Object("cross", Mesh(mesh), Pose((0.0, 0.0, 0.0))))
    start = Placement(Pose.from_rpy((-0.3, -0.35, 0.0), (0.0, 0.0, yaw)), ("table",))
    for way in ways(workspace, "cross", start):
        low = np.array([(x, y, 0.0) for a, b in CROSS for x in (a[0], b[0]) for y in (a[1], b[1])])
        T, table = way.end.pose.matrix, workspace.task.table
        sides = [low[4 * beam + np.array([0, 1, 3, 2])] @ T[:3, :3].T + T[:3, 3] for beam in range(2)]
        lines = [np.linspace(a, b, 400) for beam in sides for a, b in zip(beam, np.roll(beam, 1, axis=0), strict=True)]
        points = np.vstack([np.vstack(lines)[:, :2], corners_beneath(table, T)])
        inside = (np.abs(points - np.array(table.center)) < np.array(table.size) / 2).all(axis=1)
        assert inside_by(outline(points[inside]), T[:2, 3]) > FIRM - 0.001


def corners_beneath(table, T):
    """The corners of the table under the crossed beams at T, (n, 2): what it carries there is no edge of theirs."""
    signs = np.array([(x, y) for x in (-1, 1) for y in (-1, 1)])
    there = np.array(table.center) + signs * (np.array(table.size) / 2 - 1e-9)
    local = (there - T[:2, 3]) @ T[:2, :2]
    return there[[any(((p > a[:2]) & (p < b[:2])).all() for a, b in CROSS) for p in local]]


LID = (
    ((-0.08, -0.08, 0.0), (-0.07, 0.08, 0.05)),
    ((0.07, -0.08, 0.0), (0.08, 0.08, 0.05)),
    ((-0.08, 0.07, 0.0), (0.08, 0.08, 0.05)),
    ((-0.08, -0.08, 0.045), (0.08, 0.08, 0.05)),
)
"""A box upside down of which one side is open: it stands on three walls."""


@pytest.mark.parametrize("outward", [(1.0, 0.0), (-1.0, 0.0)])
def test_what_stands_on_walls_hangs_over_as_far_as_these_carry_it(tmp_path, outward):
    mesh = tmp_path / "lid.obj"
    mesh.write_text(parts_obj(LID))
    start = Placement(Pose.from_rpy((-0.1, 0.1, 0.0), (0.0, 0.0, 0.4)), ("table",))
    workspace = workspace_of(Object("lid", Mesh(mesh), start.pose))
    (edge,) = (edge for edge in edges(workspace, "lid", start) if tuple(edge.outward) == outward)
    assert stands(workspace, "lid", shifted(start, (edge.room + edge.farthest) * edge.outward))
    assert not stands(workspace, "lid", shifted(start, (edge.room + edge.farthest + 0.02) * edge.outward))


@settings(max_examples=20, deadline=None)
@given(yaw=st.floats(-np.pi, np.pi))
def test_the_hand_pushes_from_behind_in_line_with_the_centre_of_mass(workspace, yaw):
    start = Placement(Pose.from_rpy((-0.1, -0.3, 0.0225), (0.0, 0.0, yaw)), ("table",))
    for way in ways(workspace, "flat", start):
        ahead = way.shift / np.linalg.norm(way.shift)
        assert way.behind @ ahead < -np.cos(np.radians(21.0))
        lever = np.array(start.pose.xyz[:2]) - way.touch
        assert abs(lever[0] * ahead[1] - lever[1] * ahead[0]) < 1e-9


@pytest.mark.parametrize(("friction", "farthest"), [(0.5, 20.0), (0.3, 10.0), (0.15, 0.0)])
def test_what_is_slippery_is_pushed_no_farther_aslant_than_friction_holds(friction, farthest):
    workspace = workspace_of(replace(FLAT, friction=friction))
    found = directions(workspace, "flat", workspace.start["flat"])
    slants = np.degrees([np.arccos(np.clip(-way.ahead @ way.behind, -1.0, 1.0)) for way in found])
    assert slants.max() == pytest.approx(farthest, abs=1e-4)


@settings(max_examples=20)
@given(heading=st.floats(-np.pi, np.pi))
def test_a_round_thing_is_pushed_straight_to_wherever_it_shall_be(heading):
    scene = workspace_of(Object("disc", Cylinder(0.08, 0.02), Pose((0.05, 0.1, 0.01)), friction=0.5))
    start, shift = scene.start["disc"], 0.07 * np.array([np.cos(heading), np.sin(heading)])
    found = ways_to(scene, "disc", start, shifted(start, shift))
    assert found
    assert [way.slant for way in found] == sorted(way.slant for way in found)
    for way in found:
        np.testing.assert_allclose(way.shift, shift, atol=1e-9)
        lever = np.array(start.pose.xyz[:2]) - way.touch
        assert abs(lever[0] * shift[1] - lever[1] * shift[0]) < 1e-9


@pytest.mark.parametrize(("slant", "able"), [(0.0, True), (7.0, True), (-18.0, True), (24.0, False), (45.0, False)])
def test_a_box_is_pushed_as_far_aslant_as_friction_holds(slant, able):
    workspace = workspace_of(FLAT)
    start, angle = workspace.start["flat"], np.radians(slant)
    way = ways(workspace, "flat", start)[0]
    c, s = np.cos(angle), np.sin(angle)
    shift = -0.1 * np.array([[c, -s], [s, c]]) @ way.behind
    assert bool(ways_to(workspace, "flat", start, shifted(start, shift))) == able


def test_less_slanted_ways_are_tried_before_others_that_hang_over_as_far(workspace):
    found = ways(workspace, "flat", workspace.start["flat"])
    assert [(-way.hanging, round(way.slant, 5)) for way in found] == sorted(
        (-way.hanging, round(way.slant, 5)) for way in found
    )
    assert len({round(way.slant, 5) for way in found}) > 1


def frustum(folder, name, step):
    """A flat thing whose sides step inwards [m] from its foot to its top; outwards where that is negative."""
    x, y, z = (np.array(corner) for corner in zip(*np.ndindex(2, 2, 2), strict=True))
    corners = np.stack([0.17 * x - step * z * (2 * x - 1), 0.13 * y - step * z * (2 * y - 1), 0.045 * z], axis=1)
    hull = convex_hull(corners)
    trimesh.Trimesh(hull.vertices, hull.faces, process=False).export(folder / f"{name}.obj")
    return Object(name, Mesh(folder / f"{name}.obj"), Pose((0.0, 0.0, 0.0)), friction=1.0)


def slants(thing):
    scene = workspace_of(thing)
    found = directions(scene, thing.name, scene.start[thing.name])
    return {round(float(np.degrees(np.arccos(-way.ahead @ way.behind)))) for way in found}


def test_a_side_that_leans_back_is_pushed_less_aslant(tmp_path):
    """The fingers press on it in space; that and the slant together stay within what the checker grants."""
    straight = Object("straight", Box((0.17, 0.13, 0.045)), Pose((0.0, -0.3, 0.0225)), friction=1.0)
    assert slants(straight) == {0, 10, 20}
    assert slants(frustum(tmp_path, "leaning", 0.016)) == {0}
    assert slants(frustum(tmp_path, "steep", 0.03)) == set()


def test_a_rim_that_overhangs_is_pushed_level_at_its_edge(tmp_path):
    """As steeply as a plate's it may: upright fingers touch its upper edge with their flat."""
    assert slants(frustum(tmp_path, "plate", -0.03)) == {0, 10, 20}


def test_what_is_round_is_pushed_from_all_around():
    """Its rim is wide enough between two places where it is turned a little to either side."""
    scene = workspace_of(Object("disc", Cylinder(0.08, 0.02), Pose((0.05, 0.1, 0.01)), friction=0.5))
    behind = {tuple(np.round(way.behind, 6)) for way in directions(scene, "disc", scene.start["disc"])}
    angles = np.sort([np.degrees(np.arctan2(y, x)) for x, y in behind])
    assert np.diff([*angles, angles[0] + 360.0]).max() < 45.0
    assert ways(scene, "disc", scene.start["disc"])


def test_corners_that_are_one_but_for_rounding_have_no_side_between_them():
    square = np.array([(0.1, 0.1), (0.1, -0.1), (-0.1, -0.1), (-0.1, 0.1), (-0.1 - 1e-13, 0.1 - 1e-13)])
    sides = list(_sides(square))
    assert len(sides) == 4
    assert all(len(flat) and len(corners) for _, flat, corners in sides)
