"""Meshes whose origin is far from them: what turns about there goes far, though its origin goes nowhere."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

from tamp.checking import check
from tamp.task import At, Mesh, Object, Plan, Pose, Task, load_robot

HOME = load_robot("panda").home


@pytest.fixture(scope="module")
def far(tmp_path_factory) -> Path:
    """A box a metre beside its origin."""
    path = tmp_path_factory.mktemp("far") / "box.obj"
    box = trimesh.creation.box((0.05, 0.05, 0.06))
    box.apply_translation((0.0, 1.0, 0.0))
    box.export(path)
    return path


def idle(far: Path, turn: float) -> tuple[Task, Plan]:
    """Nothing is done: an object is said to start at its goal, turned about its origin."""
    start, goal = Pose((0.05, -1.2, 0.03)), Pose.from_rpy((0.05, -1.2, 0.03), (0.0, 0.0, turn))
    task = Task("far", (Object("red", Mesh(far), start, At(goal)),))
    return task, Plan("far", "panda", 0, {"red": goal}, HOME, {"red": goal}, ())


@pytest.mark.parametrize("turn", [0.01, 0.02, 0.045])
def test_a_turn_about_an_origin_far_away_is_no_small_way(far, turn):
    assert not check(*idle(far, turn)).accepted


def test_where_the_origin_is_makes_no_difference_to_what_stays(far):
    assert check(*idle(far, 0.0)).accepted
