"""What stands on what, which goals are fulfilled, and what goals mean where supports are a little off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.execution.settling.settle import settle
from tamp.formats.obj import box_obj
from tamp.pipeline.prepare import prepare
from tamp.pipeline.situation import placements
from tamp.task import At, Box, Mesh, Object, Pose, Task

NAMES = ("a", "b", "c", "d")
POSES = {name: Pose((0.1 * i, 0.0, 0.02)) for i, name in enumerate(NAMES)}
pairs = st.sets(st.tuples(st.sampled_from(NAMES), st.sampled_from((*NAMES, "table"))))


def cube(name, x, y, z, goal=None):
    return Object(name, Box((0.05, 0.05, 0.05)), Pose((x, y, z)), None if goal is None else At(Pose(goal)))


def ons(task, poses=None):
    settled = settle(task, poses)
    return {name: place.on for name, place in placements(settled.poses, settled.supports).items()}


@given(supports=pairs)
def test_supports_are_among_those_seen_and_never_go_round_in_a_circle(supports):
    placed = placements(POSES, sorted(supports))
    assert {name: place.pose for name, place in placed.items()} == POSES
    for name, place in placed.items():
        assert place.on
        assert list(place.on) == sorted(place.on)
        assert all((name, lower) in supports for lower in place.on) or place.on == ("table",)
    for name in NAMES:
        below, seen = set(placed[name].on), set()
        while below:
            lower = below.pop()
            assert lower != name
            if lower != "table" and lower not in seen:
                seen.add(lower)
                below |= set(placed[lower].on)


def test_a_tower_rests_on_what_is_below_each():
    supports = [("c", "b"), ("b", "a"), ("a", "table"), ("d", "table")]
    assert {name: place.on for name, place in placements(POSES, supports).items()} == {
        "a": ("table",),
        "b": ("a",),
        "c": ("b",),
        "d": ("table",),
    }


@pytest.mark.parametrize(
    ("supports", "on"),
    [
        ([("a", "b"), ("b", "a"), ("a", "table"), ("b", "table"), ("c", "a")], {"a": "table", "b": "table", "c": "a"}),
        ([("a", "b"), ("b", "a"), ("a", "table")], {"a": "table", "b": "a"}),
        ([("a", "c"), ("a", "table"), ("b", "a"), ("c", "b")], {"a": "table", "b": "a", "c": "b"}),
        ([("a", "b"), ("b", "c"), ("c", "a")], {"a": "table", "b": "table", "c": "table"}),
    ],
    ids=["each on the table", "one on the table", "three in a ring", "a ring on nothing"],
)
def test_what_stands_on_the_table_is_not_carried_by_what_it_carries(supports, on):
    placed = placements(POSES, supports)
    assert {name: placed[name].on for name in on} == {name: (lower,) for name, lower in on.items()}


def test_a_settled_tower_is_seen_as_one():
    tower = Task("tower", (cube("low", 0.0, 0.0, 0.025), cube("top", 0.0, 0.0, 0.075), cube("far", 0.0, 0.3, 0.025)))
    assert ons(tower) == {"low": ("table",), "top": ("low",), "far": ("table",)}


def test_a_plank_over_two_rests_on_both():
    plank = Object("plank", Box((0.2, 0.05, 0.02)), Pose((0.0, 0.0, 0.06)))
    bridge = Task("bridge", (cube("left", -0.08, 0.0, 0.025), cube("right", 0.08, 0.0, 0.025), plank))
    assert ons(bridge)["plank"] == ("left", "right")


def test_an_object_at_its_goal_keeps_its_start():
    task = Task(
        "there", (cube("there", 0.0, 0.1, 0.025, (0.0, 0.1, 0.025)), cube("away", 0.0, -0.1, 0.025, (0.1, 0.3, 0.025)))
    )
    setup = prepare(task)
    seen = setup.observe(setup.start)
    assert seen.goals["there"] is seen.start["there"]
    assert seen.goals["away"] is setup.goals["away"]


def test_an_object_on_a_support_that_must_move_is_not_there_yet():
    # The top one is where it shall be; what carries it shall be exchanged for another, so it must go and come back.
    task = Task(
        "exchange",
        (
            cube("low", 0.0, 0.0, 0.025, (0.0, 0.3, 0.025)),
            cube("top", 0.0, 0.0, 0.075, (0.0, 0.0, 0.075)),
            cube("next", 0.2, 0.0, 0.025, (0.0, 0.0, 0.025)),
        ),
    )
    setup = prepare(task)
    seen = setup.observe(setup.start)
    assert seen.start["top"].on == ("low",)
    assert seen.goals["top"].on == ("next",)
    assert seen.goals["top"] is not seen.start["top"]


def test_a_tower_at_its_goal_stays_as_a_whole():
    tower = (cube("low", 0.0, 0.0, 0.025, (0.0, 0.0, 0.025)), cube("top", 0.0, 0.0, 0.075, (0.0, 0.0, 0.075)))
    setup = prepare(Task("tower", tower))
    seen = setup.observe(setup.start)
    assert all(seen.goals[name] is seen.start[name] for name in ("low", "top"))


def tower(*sides):
    """Blocks of these widths [m], 5 cm high; the lowest stands 8 mm off its goal, the others away from theirs."""
    blocks = [
        Object(f"{i}", Box((side, side, 0.05)), Pose((0.3, 0.15 * i, 0.025)), At(Pose((0.0, 0.0, 0.025 + 0.05 * i))))
        for i, side in enumerate(sides)
    ]
    return Task("tower", (replace(blocks[0], pose=Pose((0.008, 0.0, 0.025))), *blocks[1:]))


def test_what_lies_flat_on_an_object_that_stays_a_little_off_keeps_its_own_goal():
    setup = prepare(tower(0.05, 0.05, 0.05))
    seen = setup.observe(setup.start)
    assert seen.goals["0"] is seen.start["0"]
    for name in ("1", "2"):
        assert np.allclose(seen.goals[name].pose.matrix, setup.goals[name].pose.matrix, atol=5e-4)


def test_what_would_fall_off_an_object_that_stays_a_little_off_moves_along():
    setup = prepare(tower(0.018, 0.05, 0.05))
    seen = setup.observe(setup.start)
    for name, shift in (("1", 0.008), ("2", 0.0)):  # the one at the top is carried where it shall be
        expected = setup.goals[name].pose.xyz[0] + shift, *setup.goals[name].pose.xyz[1:]
        assert seen.goals[name].pose.xyz == pytest.approx(expected, abs=5e-4)
        assert seen.goals[name].on == setup.goals[name].on


def channel(path):
    """Two walls, 6 cm high and 5.4 cm apart, on a floor of 1 cm; the frame is at the floor's underside."""
    boxes = [((-0.04, -0.037, 0.0), (0.04, 0.037, 0.01))]
    boxes += [((-0.04, y, 0.01), (0.04, y + 0.01, 0.07)) for y in (-0.037, 0.027)]
    text = ""
    for number, (lower, upper) in enumerate(boxes):
        lines = box_obj(f"part{number}", lower, upper).splitlines()
        faces = [line.split()[1:] for line in lines if line.startswith("f")]
        text += "\n".join(line for line in lines if not line.startswith("f")) + "\n"
        text += "".join("f " + " ".join(str(int(corner) + 8 * number) for corner in face) + "\n" for face in faces)
    path.write_text(text)
    return Mesh(path)


def test_what_fits_closely_into_an_object_that_stays_a_little_off_moves_along(tmp_path):
    goal, inside = At(Pose((0.0, 0.0, 0.0))), At(Pose((0.0, 0.0, 0.035)))
    low = Object("channel", channel(tmp_path / "channel.obj"), Pose((0.0, 0.008, 0.0)), goal)
    block = Object("block", Box((0.05, 0.05, 0.05)), Pose((0.2, 0.2, 0.025)), inside)
    setup = prepare(Task("nested", (low, block)))
    seen = setup.observe(setup.start)
    assert seen.goals["channel"] is seen.start["channel"]
    assert seen.goals["block"].pose.xyz[1] == pytest.approx(0.008, abs=1e-3)


def test_what_rests_on_two_objects_stays_where_it_shall_be_if_one_of_them_is_off():
    left = Object("left", Box((0.04, 0.04, 0.04)), Pose((0.004, 0.0, 0.02)), At(Pose((0.0, 0.0, 0.02))))
    right = Object("right", Box((0.04, 0.04, 0.04)), Pose((0.3, 0.2, 0.02)), At(Pose((0.1, 0.0, 0.02))))
    plank = Object("plank", Box((0.14, 0.04, 0.02)), Pose((0.3, -0.2, 0.01)), At(Pose((0.05, 0.0, 0.05))))
    setup = prepare(Task("bridge", (left, right, plank)))
    seen = setup.observe(setup.start)
    assert seen.goals["left"] is seen.start["left"]
    assert seen.goals["plank"] is setup.goals["plank"]


@pytest.mark.parametrize(("off", "on"), [(0.002, ("left", "right")), (0.008, ("left",))])
def test_what_no_longer_reaches_one_of_those_it_shall_lie_on_lies_on_the_others(off, on):
    left = Object("left", Box((0.1, 0.1, 0.04)), Pose((0.3, 0.2, 0.02)), At(Pose((0.0, 0.0, 0.02))))
    right = Object("right", Box((0.04, 0.04, 0.04)), Pose((0.081 + off, 0.0, 0.02)), At(Pose((0.081, 0.0, 0.02))))
    plank = Object("plank", Box((0.12, 0.04, 0.02)), Pose((0.3, -0.2, 0.01)), At(Pose((0.0015, 0.0, 0.05))))
    setup = prepare(Task("bridge", (left, right, plank)))
    seen = setup.observe(setup.start)
    assert setup.goals["plank"].on == ("left", "right")
    assert seen.goals["right"] is seen.start["right"]
    assert seen.goals["plank"].on == on
    assert seen.goals["plank"].pose == setup.goals["plank"].pose
