"""How stacks give way whose bodies hold each other up: followed from rest until they touch anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.actions.left_standing import check_rest, check_uncovered
from tamp.checking.physics.yielding import slump
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Object, Pose
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
