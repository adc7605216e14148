from dataclasses import replace
from itertools import islice, pairwise

import pytest

from tamp.pipeline.attempt import Attempt
from tamp.pipeline.setup import prepare
from tamp.pipeline.substitutes import GAIN, SETTLED, UNFIT, UNSEEN, substitutes
from tamp.scoring.ede import ede, mean_edge
from tamp.task import At, Box, Object, Pose, Sphere, Task, load_robot

LOW = Object("low", Box((0.12, 0.12, 0.06)), Pose((0.1, 0.3, 0.03)), At(Pose((0.1, -0.1, 0.03))))
HIGH = Object("high", Box((0.05, 0.05, 0.08)), Pose((0.0, 0.2, 0.04)), At(Pose((0.1, -0.1, 0.1))))


def workspace_of(*objects):
    setup = prepare(Task("tower", objects))
    return Attempt.of(setup, setup.start, load_robot("panda").home, None).workspace


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(LOW, HIGH)


def anywhere(place):
    return True


def anyhow(R):
    return True


def error(obj, place):
    return ede(mean_edge(obj.shape), place.pose, obj.goal.pose)


def test_they_come_nearest_first_and_each_is_nearer_than_the_object_is(workspace):
    places = list(islice(substitutes(workspace, "high", anywhere, anyhow), 200))
    errors = [error(HIGH, place) for place in places]
    assert len(places) == 200
    assert all(later > earlier - 1e-9 for earlier, later in pairwise(errors))
    assert errors[-1] < error(HIGH, workspace.start["high"]) - GAIN


def test_they_are_clear_of_all_that_stands_there(workspace):
    for place in islice(substitutes(workspace, "high", anywhere, anyhow), 100):
        T = place.pose.matrix
        assert not workspace.world.overlap("high", T, "table", tolerance=0.0)
        assert not workspace.world.overlap("high", T, "low", workspace.start["low"].pose.matrix, tolerance=0.0)


def test_with_the_support_missing_the_nearest_is_right_under_the_goal(workspace):
    best = next(substitutes(workspace, "high", anywhere, anyhow))
    assert best.on == ("table",)
    assert best.pose.xyz == pytest.approx((0.1, -0.1, 0.041), abs=2e-3)


def test_what_stands_where_the_goal_is_may_carry_it(workspace):
    flat = Object("flat", Box((0.12, 0.12, 0.02)), Pose((0.1, -0.1, 0.01)))
    best = next(substitutes(workspace_of(LOW, flat, HIGH), "high", anywhere, anyhow))
    assert best.on == ("flat",)
    assert best.pose.xyz == pytest.approx((0.1, -0.1, 0.061), abs=3e-3)


def test_only_what_is_worth_it_and_the_very_nearest_is_tried_in_physics():
    flat = Object("flat", Box((0.12, 0.12, 0.02)), Pose((0.1, -0.1, 0.01)))
    workspace = workspace_of(LOW, flat, HIGH)
    carried = [
        sum(place.on == ("flat",) for place in islice(substitutes(workspace, "high", worth, anyhow), 300))
        for worth in (lambda place: False, anywhere)
    ]
    assert 0 < carried[0] <= UNSEEN < carried[1] <= SETTLED


def test_where_no_hand_has_room_only_the_nearest_are_looked_at(workspace):
    assert 0 < len(list(substitutes(workspace, "high", anywhere, lambda R: False))) <= UNFIT


def test_places_as_a_hand_can_turn_the_object_are_looked_at_further_away(workspace):
    upright = HIGH.goal.pose.matrix[:3, :3]
    places = substitutes(workspace, "high", anywhere, lambda R: abs(R[2] @ upright[2]) < 0.5)
    lying = [abs(place.pose.matrix[2, :3] @ upright[2]) < 0.5 for place in islice(places, 3 * UNFIT)]
    assert lying.count(False) <= UNFIT < lying.count(True)


def test_a_ball_has_some_too():
    ball = Object("ball", Sphere(0.03), Pose((0.0, 0.2, 0.03)), At(Pose((0.1, -0.1, 0.09))))
    assert next(substitutes(workspace_of(LOW, ball), "ball", anywhere, anyhow), None) is not None


def test_an_object_near_its_goal_has_none(workspace):
    x, y, z = workspace.goals["high"].pose.xyz
    here = replace(workspace.start["high"], pose=Pose((x + 0.01, y, z)))
    assert (
        list(substitutes(replace(workspace, start={**workspace.start, "high": here}), "high", anywhere, anyhow)) == []
    )


def test_an_object_without_a_goal_pose_is_refused():
    aside = Object("aside", Box((0.05, 0.05, 0.08)), Pose((0.0, 0.2, 0.04)))
    with pytest.raises(ValueError, match="the goal of aside is no pose"):
        next(substitutes(workspace_of(LOW, aside), "aside", anywhere, anyhow))


def test_where_the_goal_has_all_that_it_rests_on_no_place_is_looked_at_in_which_no_hand_has_room():
    workspace = workspace_of(Object("alone", HIGH.shape, HIGH.pose, At(Pose((0.1, -0.1, 0.04)))))
    assert not list(substitutes(workspace, "alone", anywhere, lambda R: False))
    assert next(substitutes(workspace, "alone", anywhere, anyhow), None) is not None
