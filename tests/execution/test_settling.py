import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml

from tamp.errors import PlanningFailure
from tamp.execution.settling import let_settle, settle, supports
from tamp.execution.simulator import STEP, Simulator, Touch
from tamp.task import Box, Cylinder, Mesh, Object, Pose, Task

OCRTOC = Path(__file__).parents[3] / "shared" / "ocrtoc" / "2021"


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


def test_what_rests_stays():
    settled = settle(tower(0.05, 0.08, 0.04))
    assert settled.resting
    assert max(settled.moved.values()) < 0.001
    assert settled.supports == (("box0", "table"), ("box1", "box0"), ("box2", "box1"))


def test_settling_twice_moves_nothing_more():
    task = ocrtoc_task("1-1-1")
    once = settle(task)
    twice = settle(task, once.poses)
    assert max(twice.moved.values()) < 0.001
    assert twice.supports == once.supports


def test_settling_is_repeatable_to_the_last_bit():
    task = ocrtoc_task("2-1-1")
    assert settle(task).poses == settle(task).poses


def test_what_hangs_in_the_air_comes_down():
    task = Task("drop", (Object("can", Cylinder(0.03, 0.1), Pose((0, 0, 0.09))),))
    settled = settle(task)
    assert settled.poses["can"].xyz == pytest.approx((0, 0, 0.05), abs=0.001)
    assert settled.supports == (("can", "table"),)


def test_bodies_that_overlap_part_without_a_bang():
    task = tower(0.05, 0.05)
    top = task.objects[1]
    sunk = replace(task, objects=(task.objects[0], replace(top, pose=Pose((0.1, 0.1, 0.065)))))
    settled = settle(sunk)
    assert settled.poses["box1"].xyz == pytest.approx((0.1, 0.1, 0.075), abs=0.003)
    beside = replace(task, objects=(task.objects[0], replace(top, pose=Pose((0.14, 0.1, 0.025)))))
    settled = settle(beside)
    assert all(pose.xyz[2] == pytest.approx(0.025, abs=0.001) for pose in settled.poses.values())
    assert sum(settled.moved.values()) < 0.02


def test_absent_objects_stay_out_of_the_scene():
    task = tower(0.05, 0.05)
    settled = settle(task, {"box1": task.objects[1].pose})
    assert set(settled.poses) == {"box1"}
    assert settled.poses["box1"].xyz[2] == pytest.approx(0.025, abs=0.001)


def test_what_leans_is_supported_by_both():
    wall = Object("wall", Box((0.1, 0.02, 0.1)), Pose((0, 0, 0.05)), mass=2.0)
    plank = Object("plank", Box((0.05, 0.01, 0.12)), Pose.from_rpy((0, 0.05, 0.058), (0.45, 0, 0)))
    settled = settle(Task("lean", (wall, plank)))
    assert ("plank", "table") in settled.supports
    assert ("wall", "table") in settled.supports


def test_a_full_scene_of_many_parts_settles_nearly_where_it_was():
    task = ocrtoc_task("5-1-3")
    settled = settle(task)
    assert settled.resting
    assert max(settled.moved.values()) < 0.02
    assert all(math.isfinite(v) for pose in settled.poses.values() for v in pose.xyz)


def test_what_falls_off_the_table_is_caught_by_the_floor():
    task = Task("off", (Object("box", Box((0.05, 0.05, 0.05)), Pose((0.5, 0, 0.1))),))
    settled = settle(task)
    assert settled.poses["box"].xyz[2] == pytest.approx(-0.725, abs=0.01)
    assert settled.supports == ()


def test_steep_walls_carry_what_is_wedged_between_them():
    walls = [Touch("cup", "bowl", (side, 0.0, 0.22), 0.0, 1.0) for side in (-0.975, 0.975)]
    beside = Touch("cup", "jug", (0.0, 0.995, 0.1), 0.0, 0.1)
    assert supports(SimpleNamespace(touches=lambda: [*walls, beside])) == (("cup", "bowl"),)


def test_past_its_deadline_nothing_settles():
    with pytest.raises(PlanningFailure, match="time was up"):
        settle(tower(0.05), deadline=0.0)


class Trembling:
    """A body that jumps to and fro by a tenth of a millimetre at each step, and may creep on besides."""

    def __init__(self, creep):
        self.creep, self.steps = creep, 0

    time = property(lambda self: self.steps * STEP)
    wait = Simulator.wait

    def step(self):
        self.steps += 1

    def limit_speeds(self, linear, angular):
        pass

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
