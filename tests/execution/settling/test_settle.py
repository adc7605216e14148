from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from tamp.errors import PlanningFailure
from tamp.execution.settling import settle as settling
from tamp.execution.settling.settle import leaning, let_settle, settle, supports
from tamp.execution.simulator import STEP, Touch
from tamp.task import Box, Cylinder, Mesh, Object, Pose, Task

BOOK = Object("book", Box((0.03, 0.2, 0.25)), Pose())
WALL = Object("wall", Box((0.05, 0.2, 0.2)), Pose())
UPRIGHT = 0.2


def scene(tilt, yaw=0.0, force=1.0):
    """A book that stands on its lower edge, tilted, and touches a wall with its upper one; and their touches."""
    reach = 0.125 * math.sin(tilt) + 0.015 * math.cos(tilt)
    height = 0.125 * math.cos(tilt) + 0.015 * math.sin(tilt)
    turn = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, yaw))
    wall = turn @ Pose((reach + 0.025, 0.0, 0.1))
    poses = {"book": turn @ Pose.from_rpy((0.0, 0.0, height), (0.0, tilt, 0.0)), "wall": wall}
    foot = (turn @ Pose((0.015 * math.cos(tilt) - 0.125 * math.sin(tilt), 0.0, 0.0))).xyz
    top = (turn @ Pose((reach, 0.0, 2 * height))).xyz
    normal = (turn @ Pose((-1.0, 0.0, 0.0))).xyz
    carried = Touch("table", "book", (0.0, 0.0, -1.0), 0.0, 1.0, foot)
    return poses, [carried, Touch("book", "wall", normal, 0.0, force, top)]


def leans(poses, touches):
    return sorted(leaning((BOOK, WALL), poses, touches, UPRIGHT))


@given(tilt=st.floats(0.2, 1.0), yaw=st.floats(-3.1, 3.1))
def test_what_would_tip_over_leans_on_what_pushes_it_back_wherever_that_is(tilt, yaw):
    assert leans(*scene(tilt, yaw)) == [("book", "wall")]


@given(yaw=st.floats(-3.1, 3.1))
def test_what_stands_by_itself_leans_on_nothing_it_touches(yaw):
    poses, touches = scene(0.3, yaw)
    assert leans({**poses, "book": Pose((0.0, 0.0, 0.125))}, touches) == []


def test_it_does_not_lean_on_what_pushes_it_on_or_does_not_push_at_all():
    poses, (foot, against) = scene(0.5)
    behind = Touch("book", "wall", (1.0, 0.0, 0.0), 0.0, 1.0, against.point)
    assert leans(poses, [foot, behind]) == []
    assert leans(*scene(0.5, force=0.0)) == []


@given(yaw=st.floats(-3.1, 3.1), spread=st.floats(0.0, 1.5))
def test_what_two_bodies_hold_between_them_leans_on_both_however_narrow_they_stand(yaw, spread):
    poses, (foot, against) = scene(0.5, yaw)
    sides = (Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, sign * spread)) for sign in (1.0, -1.0))
    left, right = ((side @ Pose(against.normal)).xyz for side in sides)
    held = [
        Touch("book", "wall", left, 0.0, 1.0, against.point),
        Touch("book", "other", right, 0.0, 1.0, against.point),
    ]
    assert leans(poses, [foot, *held]) == [("book", "other"), ("book", "wall")]


@pytest.mark.parametrize(("inside", "kept"), [(0.0005, True), (0.0015, True), (0.003, False)])
def test_what_is_hardly_in_balance_leans_on_what_keeps_it_so(inside, kept):
    poses, (foot, against) = scene(math.atan2(0.015 - inside, 0.125))
    heel = replace(foot, point=(foot.point[0] - 0.01, 0.0, 0.0))  # the edge is worn
    assert leans(poses, [heel, foot, against]) == ([("book", "wall")] if kept else [])


def test_it_does_not_lean_on_what_hardly_pushes():
    poses, (foot, against) = scene(0.5)
    beside = Touch("book", "other", against.normal, 0.0, 0.05, against.point)
    assert leans(poses, [foot, against, beside]) == [("book", "wall")]


def test_either_body_of_a_touch_may_be_named_first():
    poses, (foot, against) = scene(0.5)
    x, y, z = against.normal
    assert leans(poses, [foot, Touch("wall", "book", (-x, -y, -z), 0.0, 1.0, against.point)]) == [("book", "wall")]


@pytest.mark.parametrize("touches", [[], [Touch("book", "wall", (-1.0, 0.0, 0.0), 0.0, 1.0, (0.1, 0.0, 0.1))]])
def test_what_nothing_carries_leans_on_nothing(touches):
    assert leans(scene(0.5)[0], touches) == []


def test_of_two_that_push_each_other_the_one_that_is_farther_from_standing_leans():
    poses, touches = scene(0.5)
    steeper = scene(0.2)[0]["book"].xyz[2]
    other = Object("other", BOOK.shape, Pose())
    x = touches[1].point[0] + 0.1
    poses = {"book": poses["book"], "other": Pose.from_rpy((x, 0.0, steeper), (0.0, -0.2, 0.0))}
    foot = Touch("table", "other", (0.0, 0.0, -1.0), 0.0, 1.0, (x + 0.01, 0.0, 0.0))
    against = Touch("book", "other", (-1.0, 0.0, 0.0), 0.0, 1.0, touches[1].point)
    assert list(leaning((BOOK, other), poses, [touches[0], foot, against], UPRIGHT)) == [("book", "other")]


OCRTOC = Path(__file__).parents[4] / "shared" / "ocrtoc" / "2021"


def ocrtoc_task(name):
    """A start scene of OCRTOC 2021 as a task without goals."""
    if not OCRTOC.is_dir():
        pytest.skip(f"{OCRTOC} is absent")
    objects = []
    for model, poses in yaml.safe_load((OCRTOC / "scenes" / f"{name}.yaml").read_text()).items():
        shape = Mesh(OCRTOC / "models" / model / "collision.obj")
        objects += [
            Object(f"{model}#{i}", shape, Pose.from_rpy(tuple(v[:3]), tuple(v[3:]))) for i, v in enumerate(poses)
        ]
    return Task(name, tuple(objects))


def tower(*heights):
    z, boxes = 0.0, []
    for i, height in enumerate(heights):
        boxes.append(Object(f"box{i}", Box((0.05, 0.05, height)), Pose((0.1, 0.1, z + height / 2))))
        z += height
    return Task("tower", tuple(boxes))


def test_what_rests_stays(simulator):
    settled = settle(tower(0.05, 0.08, 0.04), simulator=simulator)
    assert settled.resting
    assert max(settled.moved.values()) < 0.001
    assert settled.supports == (("box0", "table"), ("box1", "box0"), ("box2", "box1"))


def test_settling_twice_moves_nothing_more(simulator):
    task = ocrtoc_task("1-1-1")
    once = settle(task, simulator=simulator)
    twice = settle(task, once.poses, simulator=simulator)
    assert max(twice.moved.values()) < 0.001
    assert twice.supports == once.supports


def test_settling_is_repeatable_to_the_last_bit(simulator):
    task = ocrtoc_task("2-1-1")
    assert settle(task, simulator=simulator).poses == settle(task, simulator=simulator).poses


def test_what_hangs_in_the_air_comes_down(simulator):
    task = Task("drop", (Object("can", Cylinder(0.03, 0.1), Pose((0, 0, 0.09))),))
    settled = settle(task, simulator=simulator)
    assert settled.poses["can"].xyz == pytest.approx((0, 0, 0.05), abs=0.001)
    assert settled.supports == (("can", "table"),)


def test_bodies_that_overlap_part_without_a_bang(simulator):
    task = tower(0.05, 0.05)
    top = task.objects[1]
    sunk = replace(task, objects=(task.objects[0], replace(top, pose=Pose((0.1, 0.1, 0.065)))))
    settled = settle(sunk, simulator=simulator)
    assert settled.poses["box1"].xyz == pytest.approx((0.1, 0.1, 0.075), abs=0.003)
    beside = replace(task, objects=(task.objects[0], replace(top, pose=Pose((0.14, 0.1, 0.025)))))
    settled = settle(beside, simulator=simulator)
    assert all(pose.xyz[2] == pytest.approx(0.025, abs=0.001) for pose in settled.poses.values())
    assert sum(settled.moved.values()) < 0.02


def test_absent_objects_stay_out_of_the_scene(simulator):
    task = tower(0.05, 0.05)
    settled = settle(task, {"box1": task.objects[1].pose}, simulator=simulator)
    assert set(settled.poses) == {"box1"}
    assert settled.poses["box1"].xyz[2] == pytest.approx(0.025, abs=0.001)


def test_what_leans_is_supported_by_both(simulator):
    wall = Object("wall", Box((0.1, 0.02, 0.1)), Pose((0, 0, 0.05)), mass=2.0)
    plank = Object("plank", Box((0.05, 0.01, 0.12)), Pose.from_rpy((0, 0.05, 0.058), (0.45, 0, 0)))
    settled = settle(Task("lean", (wall, plank)), simulator=simulator)
    assert ("plank", "table") in settled.supports
    assert ("wall", "table") in settled.supports


def test_a_full_scene_of_many_parts_settles_nearly_where_it_was(simulator):
    task = ocrtoc_task("5-1-3")
    settled = settle(task, simulator=simulator)
    assert settled.resting
    assert max(settled.moved.values()) < 0.02
    assert all(math.isfinite(v) for pose in settled.poses.values() for v in pose.xyz)


def test_what_falls_off_the_table_is_caught_by_the_floor(simulator):
    task = Task("off", (Object("box", Box((0.05, 0.05, 0.05)), Pose((0.5, 0, 0.1))),))
    settled = settle(task, simulator=simulator)
    assert settled.poses["box"].xyz[2] == pytest.approx(-0.725, abs=0.01)
    assert settled.supports == ()


def test_steep_walls_carry_what_is_wedged_between_them():
    walls = [Touch("cup", "bowl", (side, 0.0, 0.22), 0.0, 1.0) for side in (-0.975, 0.975)]
    beside = Touch("cup", "jug", (0.0, 0.995, 0.1), 0.0, 0.1)
    assert supports(SimpleNamespace(touches=lambda: [*walls, beside])) == (("cup", "bowl"),)


def test_of_two_that_push_each_other_up_the_lower_carries():
    crate = Object("crate", Box((0.2, 0.2, 0.02)), Pose((0.0, 0.0, 0.01)))
    jammed = Object("jammed", Box((0.02, 0.02, 0.15)), Pose((0.0, 0.0, 0.09)))
    touches = [Touch("jammed", "crate", (0.5, 0.0, up), 0.0, 1.0) for up in (0.8, -0.8)]
    poses = {"crate": crate.pose, "jammed": jammed.pose}
    world = SimpleNamespace(touches=lambda: [*touches, Touch("crate", "table", (0.0, 0.0, 1.0), 0.0, 2.0)])
    assert ("crate", "jammed") in supports(world)
    assert settling._one_way((crate, jammed), poses, world) == (("crate", "table"), ("jammed", "crate"))


def test_past_its_deadline_nothing_settles(simulator):
    with pytest.raises(PlanningFailure, match="time was up"):
        settle(tower(0.05), deadline=0.0, simulator=simulator)


class Trembling:
    """A body that jumps to and fro by a tenth of a millimetre at each step, and may creep on besides."""

    def __init__(self, creep):
        self.creep, self.steps = creep, 0

    time = property(lambda self: self.steps * STEP)

    def step(self):
        self.steps += 1

    def limit_speeds(self, linear, angular):
        pass

    def touches(self):
        return ()

    def speeds(self):
        return {"body": (1e-4 / STEP, 0.0)}

    def poses(self):
        return {"body": Pose((1e-4 * (self.steps % 2) + self.creep * self.time, 0.0, 0.0))}


def test_what_trembles_on_the_spot_rests():
    body = Trembling(creep=0.0)
    assert let_settle(body, limit_s=6.0)
    assert body.time < 1.5


def test_what_creeps_does_not():
    assert not let_settle(Trembling(creep=0.005), limit_s=6.0)
