from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.streams import collisions, rubbing
from tamp.streams.rubbing import dragged_over, wedged
from tamp.streams.values import Grasp, Placement
from tamp.task import Box, Mesh, Object, Pose
from tests.streams.tables import CUBE, RED, SLAB, ToldContext, workspace_of

FROM_ABOVE = Grasp(Pose.from_rpy((0.0, 0.0, 0.02), (np.pi, 0.0, 0.0)), 0.05)
offsets = st.floats(-0.15, 0.15)
turns = st.floats(-3.1, 3.1)


@cache
def scene():
    return workspace_of(RED, SLAB, CUBE)


def placed(x, y, z, yaw=0.0):
    return Placement(Pose.from_rpy((x, y, z), (0.0, 0.0, yaw)), ("table",))


def free(obj, placement, other, standing, context=None):
    return collisions.test_cfree_placements(context or ToldContext(scene()), obj, placement, other, standing)


@given(x=offsets, y=offsets, yaw=turns)
@settings(max_examples=60, deadline=None)
def test_overlap_is_symmetric(x, y, yaw):
    red, cube = placed(0.0, 0.0, 0.04), placed(x, y, 0.02, yaw)
    assert free("red", red, "cube", cube) == free("cube", cube, "red", red)


@given(x=offsets, y=offsets)
@settings(max_examples=60, deadline=None)
def test_boxes_overlap_where_their_shadows_do(x, y):
    # Sides of 5 and 4 cm, parallel: they meet where the centres are nearer than 4.5 cm along both axes.
    depth = 0.045 - max(abs(x), abs(y))
    answer = free("red", placed(0.0, 0.0, 0.04), "cube", placed(x, y, 0.02))
    if abs(depth - collisions.GRAZED) > 1e-4:
        assert answer == (depth < collisions.GRAZED)


@given(x=offsets, y=offsets)
def test_an_object_is_never_in_its_own_way(x, y):
    context = ToldContext(scene())
    assert free("red", placed(0.0, 0.0, 0.04), "red", placed(x, y, 0.04), context)
    assert not context.reasons


def test_an_overlap_is_told():
    context = ToldContext(scene())
    assert not free("red", placed(0.0, 0.0, 0.04), "cube", placed(0.01, 0.0, 0.02), context)
    assert context.reasons == ["red would overlap cube"]


def test_only_what_settled_together_may_be_a_little_in_each_other():
    """A goal 1.5 mm inside what stands beside it is none to put something down at: it would land on that."""
    red, cube = placed(0.0, 0.0, 0.04), placed(0.0435, 0.0, 0.02)
    workspace = scene()
    together = ToldContext(replace(workspace, start={**workspace.start, "red": red, "cube": cube}))
    aimed = ToldContext(replace(workspace, start={**workspace.start, "cube": cube}, goals={"red": red}))
    moved = ToldContext(replace(workspace, start={**workspace.start, "cube": cube}))
    assert free("red", red, "cube", cube, together)
    assert free("red", red, "cube", cube, aimed), "the cube has no goal: where it stands the red one settled beside it"
    assert not free("red", red, "cube", cube, moved)


def test_of_what_settled_beside_one_another_the_checker_bears_less_where_both_are_convex():
    red, cube = placed(0.0, 0.0, 0.04), placed(0.0427, 0.0, 0.02)
    workspace = scene()
    given = ToldContext(replace(workspace, start={**workspace.start, "red": red, "cube": cube}))
    aimed = ToldContext(replace(workspace, start={**workspace.start, "cube": cube}, goals={"red": red}))
    assert free("red", red, "cube", cube, given), "so the task has them: nothing is put there"
    assert not free("red", red, "cube", cube, aimed)


def test_in_what_carries_it_a_thin_thing_is_no_deeper_than_tells_on_which_side_of_a_wall_it_is(tmp_path):
    """Two millimetres deep is nothing beside 2 cm, but half of a wall of 4 mm: the checker calls it inside."""
    for wide, free_there in ((0.02, True), (0.004, False)):
        rack = Object("rack", Mesh(walls_apart(tmp_path, 0.03, wide)), Pose((0.0, 0.0, 0.0)))
        card = Object("card", Box((0.003, 0.06, 0.06)), Pose((0.3, 0.0, 0.03)))
        workspace = workspace_of(card, rack)
        at = Placement(Pose((0.015 + 0.002 - 0.0015, 0.0, 0.03)), ("rack",))
        assert free("card", at, "rack", workspace.start["rack"], ToldContext(workspace)) == free_there


def walls_apart(folder, gap, thickness):
    """A mesh of two walls, 10 cm high, that face each other across a gap along x [m]."""
    path = folder / f"walls-{thickness}.obj"
    lines, first = list[str](), 1
    for side in (-1, 1):
        wall = trimesh.creation.box((thickness, 0.1, 0.1))
        wall.apply_translation((side * (gap + thickness) / 2, 0.0, 0.05))
        lines += [f"o wall{first}", *("v {:.6f} {:.6f} {:.6f}".format(*v) for v in wall.vertices)]
        lines += ["f {} {} {}".format(*(face + first)) for face in wall.faces]
        first += len(wall.vertices)
    path.write_text("\n".join(lines))
    return path


@pytest.mark.parametrize(
    ("gap", "beside", "stuck"),
    [(0.0396, 0.0, True), (0.0404, 0.0, False), (0.0396, 0.0003, True), (0.05, 0.0053, False)],
)
def test_between_two_walls_that_both_press_it_is_wedged_and_before_one_it_is_not(tmp_path, gap, beside, stuck):
    block = Object("block", Box((0.04, 0.04, 0.04)), Pose((0.3, 0.0, 0.02)))
    world = workspace_of(block, Object("slot", Mesh(walls_apart(tmp_path, gap, 0.01)), Pose((0.0, 0.0, 0.0)))).world
    passed = np.array([Pose((beside, 0.0, z)).matrix for z in np.arange(0.02, 0.1, 0.002)])
    found = wedged(world, "block", passed, {"slot": np.eye(4)})
    assert (found is not None and found.b == "slot") == stuck


def test_what_stands_level_on_another_is_not_dragged_off_it():
    world = scene().world
    along = np.array([Pose((x, 0.0, 0.0499)).matrix for x in np.arange(0.0, 0.03, 0.002)])
    upwards = np.array([Pose((x, 0.0, 0.05 + x)).matrix for x in np.arange(0.0, 0.03, 0.002)])
    slab = {"slab": Pose((0.0, 0.0, 0.015)).matrix}
    assert dragged_over(world, "cube", along, slab) is not None
    assert dragged_over(world, "cube", upwards, slab) is None


def test_what_rests_on_another_is_free_of_it():
    assert free("cube", placed(0.0, 0.0, 0.05), "slab", placed(0.0, 0.0, 0.015))


@given(depth=st.floats(-0.001, 0.002), length=st.floats(0.0, 0.05))
@settings(max_examples=60, deadline=None)
def test_what_presses_on_another_as_it_slides_takes_that_along(depth, length):
    cube = placed(0.045 - depth, 0.0, 0.02).pose.matrix
    way = np.linspace(0.0, length, 12)
    passed = np.array([placed(0.0 if aside else -0.01, 0.0, 0.04 + aside).pose.matrix for aside in way])
    contact = rubbing.rubbed(scene().world, "red", passed, {"cube": cube})
    rubs = depth > rubbing.PRESSED and length * 10 / 11 > rubbing.RUBBED
    near = abs(depth - rubbing.PRESSED) < 1e-5 or abs(length * 10 / 11 - rubbing.RUBBED) < 1e-3
    assert near or (contact is not None) == rubs
