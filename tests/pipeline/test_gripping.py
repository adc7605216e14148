import math

import numpy as np

from tamp.pipeline.attempt import Attempt
from tamp.pipeline.gripping import KEPT, Grips
from tamp.pipeline.setup import prepare
from tamp.streams.values import Placement
from tamp.task import Box, Mesh, Object, Pose, Task, load_robot
from tests.pipeline.samplers import no_grasp
from tests.streams.tables import OBJECTS

CUBE = Box((0.05, 0.05, 0.05))
RED = Object("red", CUBE, Pose((0.1, 0.1, 0.025)))
TOP = Object("top", CUBE, Pose((0.1, 0.1, 0.075)))
WIDE = Object("wide", Box((0.12, 0.12, 0.04)), Pose((0.1, 0.1, 0.02)))
THERE = Placement(Pose((0.1, -0.2, 0.026)), ("table",))


def grips(*objects, samplers=None):
    setup = prepare(Task("grips", objects))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, samplers)
    return Grips(attempt.workspace, objects[0].name, attempt.samplers, 0, math.inf)


def test_what_can_be_taken_can_be_put_to_a_free_place():
    red = grips(RED)
    assert 0 < len(red.grasps) <= KEPT
    serving = red.serving(THERE)
    assert serving
    assert set(serving) <= set(red.roomy(THERE)) <= set(red.grasps)


def test_the_same_seed_finds_the_same():
    assert grips(RED).grasps == grips(RED).grasps


def test_beside_a_wall_on_every_side_there_is_no_room():
    x, y, _ = THERE.pose.xyz
    walls = [
        Object(f"wall-{n}", Box((0.02, 0.3, 0.3) if dx else (0.15, 0.02, 0.3)), Pose((x + dx, y + dy, 0.15)))
        for n, (dx, dy) in enumerate(((0.1, 0.0), (-0.1, 0.0), (0.0, 0.05), (0.0, -0.05)))
    ]
    red = grips(RED, *walls)
    assert red.grasps
    assert red.serving(THERE) == ()


def test_nothing_takes_what_carries_others_or_is_too_wide_or_nobody_grasps():
    assert grips(RED, TOP).grasps == ()
    assert grips(WIDE).grasps == ()
    assert grips(RED, samplers={"sample-grasp": no_grasp}).grasps == ()


def test_a_hand_from_above_fits_as_the_object_stands_and_not_upside_down():
    red = grips(Object("red", Box((0.05, 0.05, 0.02)), Pose((0.1, 0.1, 0.01))))
    assert red.grasps
    assert red.fits(np.eye(3))
    assert not red.fits(np.diag([1.0, -1.0, -1.0]))


def test_what_finds_no_room_for_the_hand_in_a_crate_may_be_dropped_into_it():
    crate = Object("crate", Mesh(OBJECTS / "open_box" / "collision.obj", 1.5), Pose((0.10, -0.22, 0.045)))
    block = grips(Object("block", Box((0.04, 0.05, 0.03)), Pose((0.05, 0.2, 0.015))), crate)
    assert block.serving(Placement(Pose((0.012, -0.352, 0.022)), ("crate",)))
    assert not block.serving(Placement(Pose((0.012, -0.352, 0.022)), ("table",)))
