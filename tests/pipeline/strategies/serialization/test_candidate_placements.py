from __future__ import annotations

from dataclasses import replace
from itertools import islice, pairwise

import pytest

from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.serialization import candidate_placements as resting
from tamp.pipeline.strategies.serialization.candidate_placements import (
    GAIN,
    SETTLED,
    UNFIT,
    UNSEEN,
    lowered,
    on_table,
    settled,
    substitutes,
)
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.scoring.ede import ede, mean_edge
from tamp.streams.collisions import overlap
from tamp.streams.values import Placement
from tamp.task import At, Box, Object, Pose, Sphere, Task, load_robot

BASE = Object("base", Box((0.1, 0.1, 0.04)), Pose((0.1, 0.0, 0.02)))
BLOCK = Object("block", Box((0.04, 0.04, 0.06)), Pose((0.0, 0.25, 0.03)))


@pytest.fixture(scope="module")
def workspace():
    setup = prepare(Task("two", (BASE, BLOCK)))
    return Attempt.of(setup, setup.start, load_robot("panda").home, None).workspace


def down(workspace, xyz):
    return lowered(workspace, "block", Pose(xyz), 0.031, {"base": workspace.start["base"]})


def test_it_stops_just_above_what_is_below(workspace):
    place = down(workspace, (0.1, 0.0, 0.3))
    assert place.on == ("base",)
    assert 0.07 < place.pose.xyz[2] < 0.074
    assert not workspace.world.overlap("block", place.pose.matrix, "base", BASE.pose.matrix, tolerance=0.0)


def test_beside_everything_it_comes_down_to_the_table(workspace):
    place = down(workspace, (0.1, 0.2, 0.3))
    assert place.on == ("table",)
    assert place.pose.xyz == pytest.approx((0.1, 0.2, 0.031))


def test_what_is_let_go_over_a_support_rests_on_it(workspace):
    place = settled(workspace, "block", down(workspace, (0.1, 0.0, 0.3)))
    assert place.on == ("base",)
    assert place.pose.xyz == pytest.approx((0.1, 0.0, 0.071), abs=3e-3)


def test_what_is_let_go_half_over_an_edge_rests_lower_and_leaning(workspace):
    above = down(workspace, (0.165, 0.0, 0.3))
    place = settled(workspace, "block", above)
    assert place.pose.xyz[2] < above.pose.xyz[2] - 0.01


def test_where_it_falls_off_the_table_or_pushes_others_it_has_no_place(workspace, monkeypatch):
    assert settled(workspace, "block", Placement(Pose((3.0, 0.0, 0.05)), ("table",))) is None
    above = down(workspace, (0.1, 0.0, 0.3))
    monkeypatch.setattr(resting, "PUSHED", -1.0)
    assert settled(workspace, "block", above) is None


def settling_with(monkeypatch, with_block=None, **changes):
    """Let scenes come to rest with these entries changed of what is found; all scenes, or those with a block or not."""
    settle = resting.settle

    def changed(task, poses, **options):
        after = settle(task, poses, **options)
        if with_block not in (None, "block" in poses):
            return after
        return replace(after, **{field: {**getattr(after, field), **entries} for field, entries in changes.items()})

    monkeypatch.setattr(resting, "settle", changed)


@pytest.mark.parametrize(
    ("shift", "tilt", "pushed"), [(0.003, 0.0, False), (0.006, 0.0, True), (0.0, 0.02, False), (0.0, 0.15, True)]
)
def test_what_moves_or_tilts_by_more_than_a_little_is_pushed(workspace, monkeypatch, shift, tilt, pushed):
    there = Pose((shift, 0.0, 0.0)) @ workspace.start["base"].pose @ Pose.from_rpy((0.0, 0.0, 0.0), (tilt, 0.0, 0.0))
    settling_with(monkeypatch, with_block=True, poses={"base": there})
    assert (settled(workspace, "block", down(workspace, (0.1, 0.0, 0.3))) is None) == pushed


@pytest.mark.parametrize(
    ("alone", "together", "pushed"), [(0.006, 0.007, False), (0.006, 0.012, True), (0.02, 0.02, True)]
)
def test_what_moves_a_little_by_itself_is_not_pushed(workspace, monkeypatch, alone, together, pushed):
    for with_block, shift in ((False, alone), (True, together)):
        there = Pose((shift, 0.0, 0.0)) @ workspace.start["base"].pose
        settling_with(monkeypatch, with_block=with_block, poses={"base": there})
    assert (settled(workspace, "block", down(workspace, (0.1, 0.0, 0.3))) is None) == pushed


def test_what_sinks_into_others_is_let_go_clear_of_them(workspace, monkeypatch):
    place = settled(workspace, "block", down(workspace, (0.1, 0.0, 0.3)))
    sunk = Pose((*place.pose.xyz[:2], place.pose.xyz[2] - 0.006), place.pose.quat)
    settling_with(monkeypatch, poses={"block": sunk})
    found = settled(workspace, "block", place)
    assert sunk.xyz[2] + 0.002 < found.pose.xyz[2] < place.pose.xyz[2]
    assert not overlap(workspace, "block", found, "base", workspace.start["base"])
    monkeypatch.setattr(resting, "SUNK", 1)
    assert settled(workspace, "block", place) is None


def test_what_moves_far_away_is_no_matter_but_what_moves_on_its_support_is():
    setup = prepare(Task("two", (BASE, BLOCK, Object("far", BLOCK.shape, Pose((-0.1, -0.4, 0.03))))))
    for far, disturbed in (((-0.1, -0.4, 0.08), False), ((0.13, 0.03, 0.13), True)):
        floating = {**setup.start, "far": Pose(far)}
        workspace = Attempt.of(setup, floating, load_robot("panda").home, None).workspace
        assert (settled(workspace, "block", Placement(Pose((0.08, -0.02, 0.072)), ("base",))) is None) == disturbed


LOW = Object("low", Box((0.12, 0.12, 0.06)), Pose((0.1, 0.3, 0.03)), At(Pose((0.1, -0.1, 0.03))))
HIGH = Object("high", Box((0.05, 0.05, 0.08)), Pose((0.0, 0.2, 0.04)), At(Pose((0.1, -0.1, 0.1))))


def workspace_of(*objects):
    setup = prepare(Task("tower", objects))
    return Attempt.of(setup, setup.start, load_robot("panda").home, None).workspace


@pytest.fixture(scope="module")
def crowded():
    return workspace_of(LOW, HIGH)


def anywhere(place):
    return True


def anyhow(R):
    return True


def error(obj, place):
    return ede(mean_edge(obj.shape), place.pose, obj.goal.pose)


def test_they_come_nearest_first_and_each_is_nearer_than_the_object_is(crowded):
    places = list(islice(substitutes(crowded, "high", anywhere, anyhow), 200))
    errors = [error(HIGH, place) for place in places]
    assert len(places) == 200
    assert all(later > earlier - 1e-9 for earlier, later in pairwise(errors))
    assert errors[-1] < error(HIGH, crowded.start["high"]) - GAIN


def test_they_are_clear_of_all_that_stands_there(crowded):
    for place in islice(substitutes(crowded, "high", anywhere, anyhow), 100):
        T = place.pose.matrix
        assert not crowded.world.overlap("high", T, "table", tolerance=0.0)
        assert not crowded.world.overlap("high", T, "low", crowded.start["low"].pose.matrix, tolerance=0.0)


def test_with_the_support_missing_the_nearest_is_right_under_the_goal(crowded):
    best = next(substitutes(crowded, "high", anywhere, anyhow))
    assert best.on == ("table",)
    assert best.pose.xyz == pytest.approx((0.1, -0.1, 0.041), abs=2e-3)


def test_what_stands_where_the_goal_is_may_carry_it(crowded):
    flat = Object("flat", Box((0.12, 0.12, 0.02)), Pose((0.1, -0.1, 0.01)))
    best = next(substitutes(workspace_of(LOW, flat, HIGH), "high", anywhere, anyhow))
    assert best.on == ("flat",)
    assert best.pose.xyz == pytest.approx((0.1, -0.1, 0.061), abs=3e-3)


def test_on_the_table_they_come_nearest_first_and_stand_free(crowded):
    places = on_table(crowded, "high", anyhow)
    errors = [error(HIGH, place) for place in places]
    assert places
    assert errors == sorted(errors)
    for place in places:
        assert place.on == ("table",)
        assert not crowded.world.overlap("high", place.pose.matrix, "table", tolerance=0.0)
        assert not crowded.world.overlap(
            "high", place.pose.matrix, "low", crowded.start["low"].pose.matrix, tolerance=0.0
        )


def test_only_what_is_worth_it_and_the_very_nearest_is_tried_in_physics():
    flat = Object("flat", Box((0.12, 0.12, 0.02)), Pose((0.1, -0.1, 0.01)))
    crowded = workspace_of(LOW, flat, HIGH)
    carried = [
        sum(place.on == ("flat",) for place in islice(substitutes(crowded, "high", worth, anyhow), 300))
        for worth in (lambda place: False, anywhere)
    ]
    assert 0 < carried[0] <= UNSEEN < carried[1] <= SETTLED


def test_where_no_hand_has_room_only_the_nearest_are_looked_at(crowded):
    assert 0 < len(list(substitutes(crowded, "high", anywhere, lambda R: False))) <= UNFIT


@pytest.mark.parametrize("occupied", [False, True])
def test_where_no_hand_has_room_the_neighbours_of_a_goal_are_looked_at_if_something_else_is_there(occupied):
    goal = Pose((0.1, -0.1, 0.03))
    thing = Object("thing", Box((0.06, 0.06, 0.06)), Pose((0.0, 0.2, 0.03)), At(goal))
    other = Object("other", Box((0.06, 0.06, 0.06)), Pose((0.1, -0.1 if occupied else 0.3, 0.03)))
    workspace = workspace_of(thing, other)
    workspace = replace(workspace, goals={"thing": Placement(goal, ("table",))})
    found = next(substitutes(workspace, "thing", anywhere, lambda R: False), None)
    assert (found is not None) == occupied


def test_places_as_a_hand_can_turn_the_object_are_looked_at_further_away(crowded):
    upright = HIGH.goal.pose.matrix[:3, :3]
    places = substitutes(crowded, "high", anywhere, lambda R: abs(R[2] @ upright[2]) < 0.5)
    lying = [abs(place.pose.matrix[2, :3] @ upright[2]) < 0.5 for place in islice(places, 3 * UNFIT)]
    assert lying.count(False) <= UNFIT < lying.count(True)


def test_a_ball_has_some_too():
    ball = Object("ball", Sphere(0.03), Pose((0.0, 0.2, 0.03)), At(Pose((0.1, -0.1, 0.09))))
    assert next(substitutes(workspace_of(LOW, ball), "ball", anywhere, anyhow), None) is not None


def test_an_object_near_its_goal_has_none(crowded):
    x, y, z = crowded.goals["high"].pose.xyz
    here = replace(crowded.start["high"], pose=Pose((x + 0.01, y, z)))
    assert list(substitutes(replace(crowded, start={**crowded.start, "high": here}), "high", anywhere, anyhow)) == []


def test_an_object_without_a_goal_pose_is_refused():
    aside = Object("aside", Box((0.05, 0.05, 0.08)), Pose((0.0, 0.2, 0.04)))
    with pytest.raises(ValueError, match="the goal of aside is no pose"):
        next(substitutes(workspace_of(LOW, aside), "aside", anywhere, anyhow))


def test_where_the_goal_has_all_that_it_rests_on_no_place_is_looked_at_in_which_no_hand_has_room():
    crowded = workspace_of(Object("alone", HIGH.shape, HIGH.pose, At(Pose((0.1, -0.1, 0.04)))))
    assert not list(substitutes(crowded, "alone", anywhere, lambda R: False))
    assert next(substitutes(crowded, "alone", anywhere, anyhow), None) is not None


def test_what_does_not_stay_under_an_object_is_tried_again_after_places_further_away(monkeypatch):
    flat = Object("flat", Box((0.06, 0.1, 0.02)), Pose((0.1, -0.1, 0.01)))
    beside = Object("beside", Box((0.12, 0.3, 0.02)), Pose((0.192, -0.1, 0.01)))
    crowded, tried = workspace_of(LOW, flat, beside, HIGH), list[tuple[str, ...]]()

    def come_to_rest(workspace, name, place, simulator):
        tried.append(place.on)
        return (None, frozenset({"flat"})) if "flat" in place.on else (place, frozenset())

    monkeypatch.setattr(resting, "_come_to_rest", come_to_rest)
    vain = []
    for farther in (0.0, resting.UPSET):
        monkeypatch.setattr(resting, "UPSET", farther)
        tried.clear()
        next((p for p in substitutes(crowded, "high", anywhere, anyhow) if p.on == ("beside",)), None)
        vain.append(sum("flat" in on for on in tried))
    assert 0 < vain[1] < vain[0]
