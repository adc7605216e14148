import pytest

from tamp.pipeline import resting
from tamp.pipeline.attempt import Attempt
from tamp.pipeline.resting import lowered, settled
from tamp.pipeline.setup import prepare
from tamp.streams.values import Placement
from tamp.task import Box, Object, Pose, Task, load_robot

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


def test_what_moves_far_away_is_no_matter_but_what_moves_on_its_support_is():
    setup = prepare(Task("two", (BASE, BLOCK, Object("far", BLOCK.shape, Pose((-0.1, -0.4, 0.03))))))
    for far, disturbed in (((-0.1, -0.4, 0.08), False), ((0.13, 0.03, 0.13), True)):
        floating = {**setup.start, "far": Pose(far)}
        workspace = Attempt.of(setup, floating, load_robot("panda").home, None).workspace
        assert (settled(workspace, "block", Placement(Pose((0.08, -0.02, 0.072)), ("base",))) is None) == disturbed
