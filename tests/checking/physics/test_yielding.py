"""How stacks give way whose bodies hold each other up: followed from rest until they touch anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.actions.left_standing import check_rest, check_uncovered
from tamp.checking.physics.yielding import gives_way, slump
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Object, Pose
from tamp.task.mesh.parts import convex_hull
from tests.checking.mutations.solids import hulls
from tests.checking.physics.heaps import PUT_ON_LEANING, TAKEN_FROM_LEANING, said, scene_of, turned
from tests.checking.physics.hollow_heaps import PUT_ON_HOLLOW, TAKEN_FROM_HOLLOW


def slumped(*objects: Object, most: float = 0.1) -> dict[str, float]:
    """How far a stack gives way, of which the first object is one."""
    scene, state = scene_of(objects)
    return slump(scene, state, objects[0].name, most, replace(DEFAULT, standing=DEFAULT.touching))


def heaps(*named):
    """Heaps by their titles, as a test's parameters."""
    return [pytest.param(heap, id=title) for group in named for title, heap in group.items()]


@pytest.mark.parametrize("heap", heaps(TAKEN_FROM_LEANING, TAKEN_FROM_HOLLOW))
def test_what_leans_on_others_gives_way_when_one_is_taken(heap):
    assert any("gives way" in sentence for sentence in said(check_uncovered, heap))


@pytest.mark.parametrize("heap", heaps(PUT_ON_LEANING, PUT_ON_HOLLOW))
def test_what_is_put_on_what_does_not_hold_it_goes_on(heap):
    assert said(check_rest, heap)


@given(yaw=st.floats(-3.0, 3.0), count=st.integers(1, 4), seed=st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_what_stands_level_gives_way_by_nothing(yaw, count, seed):
    rng, high, objects = np.random.default_rng(seed), 0.0, list[Object]()
    for index in range(count):
        size = tuple(float(edge) for edge in rng.uniform(0.03, 0.06, 3))
        aside = rng.uniform(-0.002, 0.002, 2)
        pose = Pose((float(aside[0]), float(aside[1]), high + size[2] / 2))
        objects.append(Object(f"o{index}", Box(size), pose, mass=float(rng.uniform(0.05, 1.0))))
        high += size[2]
    assert max(slumped(*turned(tuple(objects), yaw)).values()) < 0.001


@given(yaw=st.floats(-3.0, 3.0), drop=st.floats(0.002, 0.03))
@settings(max_examples=20, deadline=None)
def test_what_hangs_in_the_air_comes_down_to_what_is_under_it(yaw, drop):
    box = Object("box", Box((0.05, 0.05, 0.05)), Pose((0.0, 0.0, 0.025 + drop)))
    assert slumped(*turned((box,), yaw))["box"] == pytest.approx(drop, abs=0.001)


@given(yaw=st.floats(-3.0, 3.0), lean=st.one_of(st.floats(0.02, 0.08), st.floats(0.18, 0.5)))
@settings(max_examples=20, deadline=None)
def test_a_board_that_nothing_holds_lies_down(yaw, lean):
    board = Box((0.02, 0.1, 0.2))
    z = (0.2 * np.cos(lean) + 0.02 * np.sin(lean)) / 2
    thing = Object("board", board, Pose.from_rpy((0.0, 0.0, float(z)), (0.0, lean, 0.0)), friction=1.0)
    falls = np.tan(lean) > 0.02 / 0.2
    assert (slumped(*turned((thing,), yaw), most=0.03)["board"] > 0.03) == falls


@pytest.mark.parametrize("beyond", [-0.001, 0.001])
def test_friction_holds_nothing_whose_middle_is_beyond_the_edge(beyond):
    block = Object("block", Box((0.1, 0.1, 0.05)), Pose((0.0, 0.0, 0.025)), mass=2.0, friction=1.5)
    slab = Object("slab", Box((0.2, 0.06, 0.02)), Pose((0.05 + beyond, 0.0, 0.06)), mass=0.2, friction=1.5)
    assert (slumped(*turned((slab, block), 0.3), most=0.03)["slab"] > 0.03) == (beyond > 0.0)


@pytest.mark.parametrize("held", [True, False])
def test_what_sets_out_by_itself_before_a_change_is_not_said_to_go_on_with_momentum(held):
    """A prism of 16 faces leans beyond its balance on a slope, and the block is taken away that holds it, or stops it.

    Followed from rest it stays on its next face; with the momentum that it gains it rolls on. That counts for what the
    block held; for what sets out by itself, and comes down on that face beside the block, it tells nothing.
    """
    radius, half, slope, most = 0.02, np.pi / 16, 0.14, 0.02
    flat, edge = radius * np.cos(half), radius * np.sin(half)
    angles = half * (1 + 2 * np.arange(16))
    ring = radius * np.stack([np.sin(angles), 0.0 * angles, np.cos(angles)], axis=1)
    prism = hulls("prism_of_16", [convex_hull(np.vstack([np.add(ring, (0.0, y, 0.0)) for y in (-0.02, 0.02)]))])
    corners = [(x, y, z) for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (-0.03, -x * np.tan(slope))]
    wedge = hulls("wedge_of_8_degrees", [convex_hull(np.array(corners))])
    down = Pose.from_rpy((0.0, 0.0, 0.03), (0.0, slope, 0.0))
    leans = Pose.from_rpy((edge, 0.0, 0.0), (0.0, half - slope + 0.015, 0.0)) @ Pose((-edge, 0.0, flat))
    front = float((ring @ leans.matrix[0, :3]).max() + leans.xyz[0]) if held else 2 * edge + flat
    things = (
        Object("wedge", wedge, Pose((0.0, 0.0, 0.03)), mass=50.0, friction=1.0),
        Object("prism", prism, down @ leans, friction=1.0),
        Object("block", Box((0.03, 0.06, 0.06)), down @ Pose((front + 0.0151, 0.0, 0.03)), mass=20.0, friction=1.0),
    )
    scene, before = scene_of(things)
    near, after = replace(DEFAULT, standing=DEFAULT.touching), before.without("block")
    assert (slump(scene, before, "prism", most, near)["prism"] < 1e-6) == held
    assert bool(list(gives_way(scene, before, after, ["prism"], most, near))) == held
