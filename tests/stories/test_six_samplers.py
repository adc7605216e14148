"""Six samplers, written from the manual alone: grasps on meshes, placements on a grid, own inverse kinematics, another
motion planner, a learned one, and a bad one. Five plan a task together; the kit says what is wrong with the sixth.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import tamp
from tamp.conformance import check_sampler
from tests.docs.manual import undocumented
from tests.stories import six_samplers as six

SCENARIOS = Path(__file__).parents[2] / "scenarios"
MUG = tamp.Mesh(SCENARIOS / "objects" / "mug" / "collision.obj")


@pytest.fixture(scope="module")
def tidy() -> tamp.Task:
    mug = tamp.Object("mug", MUG, tamp.Pose((0.05, 0.2, 0.05)), goal=tamp.On("shelf"))
    tin = tamp.Object("tin", tamp.Cylinder(0.03, 0.09), tamp.Pose((0.12, 0.05, 0.045)))
    return tamp.Task("tidy", (mug, tin), regions=(tamp.Region("shelf", (0.05, -0.2), (0.2, 0.2)),))


def test_documented_places_are_enough() -> None:
    assert undocumented(Path(str(six.__file__))) == set()


def test_five_of_them_plan_together(tidy: tamp.Task) -> None:
    mine = {
        "sample-grasp": six.mesh_grasps,
        "sample-placement": six.learned_places,
        "inverse-kinematics": six.own_kinematics,
        "plan-free-motion": six.by_kpiece,
    }
    plan = tamp.plan(tidy, samplers=mine, timeout=200.0)
    assert [action.name for action in plan.actions] == ["move", "pick", "move", "place"]
    assert tamp.check(tidy, plan).accepted


def test_the_kit_names_what_is_wrong_with_the_bad_one(tidy: tamp.Task) -> None:
    judgement = check_sampler(six.in_millimetres, "sample-grasp", tasks=[tidy])
    assert not judgement.fits
    assert "width is 50; the gripper opens 0 to 0.08 m" in str(judgement)
