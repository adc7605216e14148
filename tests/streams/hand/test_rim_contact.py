from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from tamp.checking.geometry.pad_region import squeezed_out
from tamp.checking.geometry.transforms import inverse
from tamp.checking.scene import Scene
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.hand import finger_closing
from tamp.streams.hand.rim_contact import MET, slips_off, steepness
from tamp.streams.values import Grasp
from tamp.task import Box, Mesh, Object, Pose
from tests.streams.tables import OBJECTS, ToldContext, panda, workspace_of

DOWN = Pose.from_rpy((0.0, 0.0, 0.0), (np.pi, 0.0, 0.0))
GRIPPER = panda().spec.gripper


def hull(path: Path, points: np.ndarray) -> Mesh:
    """The convex hull of points as a mesh file."""
    found = ConvexHull(points)
    lines = ["o hull", *(f"v {x} {y} {z}" for x, y, z in points)]
    for corners, plane in zip(found.simplices, found.equations, strict=True):
        a, b, c = points[corners]
        order = corners if np.cross(b - a, c - a) @ plane[:3] > 0 else corners[::-1]
        lines.append("f " + " ".join(str(i + 1) for i in order))
    path.write_text("\n".join(lines) + "\n")
    return Mesh(path)


def refused(scene: Scene, grasp: Grasp) -> bool:
    """Whether the checker says that the only object slips out of this grasp."""
    (obj,) = scene.task.objects
    opening = min(GRIPPER.stroke, grasp.width + 2 * grasp.clearance)
    T = inverse(grasp.T_object_tool.matrix)
    return squeezed_out(scene.solids[obj.name], T, GRIPPER, opening, obj.friction) is not None


def pebble(tmp_path: Path, seed: int) -> Object:
    """A random polyhedron a few centimetres wide: nearly all its faces are slopes to some pad."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(8, 20)), 3)) * rng.uniform(0.012, 0.022, 3)
    shape = hull(tmp_path / "pebble.obj", points - points.mean(axis=0))
    return Object("pebble", shape, Pose((0.0, 0.1, 0.06)), friction=0.2)


@pytest.mark.parametrize("seed", [*range(4), 27, 31, 32, 42, 45, 55])
def test_the_checker_refuses_no_grasp_of_a_pebble_for_its_slopes(tmp_path, seed):
    workspace = workspace_of(pebble(tmp_path, seed))
    scene = Scene.of(workspace.task)
    found = list(islice(sample_grasp(ToldContext(workspace), "pebble"), 40))
    assert found
    assert not any(refused(scene, grasp) for grasp in found)


def test_grasps_that_the_checker_would_refuse_are_among_those_left_out(tmp_path, monkeypatch):
    monkeypatch.setattr(finger_closing, "slips_off", lambda *asked: False)
    refusals, left_out = 0, 0
    for seed in range(2):
        workspace = workspace_of(pebble(tmp_path, seed))
        scene = Scene.of(workspace.task)
        for grasp in islice(sample_grasp(ToldContext(workspace), "pebble"), 40):
            refusals += refused(scene, grasp)
            left_out += slips_off(workspace, "pebble", grasp)
    assert 0 < refusals <= left_out


@pytest.mark.parametrize("thing", ["cup", "plate", "bowl", "bottle"])
def test_the_checker_refuses_no_grasp_of_crockery_for_its_slopes(thing):
    workspace = workspace_of(Object(thing, Mesh(OBJECTS / thing / "collision.obj"), Pose((0.05, 0.15, 0.06))))
    scene = Scene.of(workspace.task)
    found = list(islice(sample_grasp(ToldContext(workspace), thing), 20))
    assert found
    assert not any(refused(scene, grasp) for grasp in found)


@pytest.mark.parametrize("degrees", [10.0, 30.0, 50.0])
def test_the_sides_of_a_wedge_are_as_steep_as_they_are(tmp_path, degrees):
    rise = np.tan(np.radians(degrees))
    width = {z: 0.01 + rise * z for z in (-0.008 / rise, 0.015)}
    points = np.array([(a * 0.03, b * w, z) for a in (-1, 1) for b in (-1, 1) for z, w in width.items()])
    workspace = workspace_of(Object("wedge", hull(tmp_path / "wedge.obj", points), Pose((0.0, 0.0, 0.05))))
    grasp = Grasp(DOWN, 2 * (0.01 + rise * GRIPPER.pad[2] / 2), 0.001)
    assert steepness(workspace, "wedge", grasp) == pytest.approx(rise, rel=1e-6)


def test_the_faces_of_a_box_meet_those_of_the_pads():
    workspace = workspace_of(Object("box", Box((0.05, 0.03, 0.08)), Pose((0.0, 0.0, 0.04)), friction=0.05))
    assert steepness(workspace, "box", Grasp(DOWN, 0.03, 0.004)) == 0.0
    assert not slips_off(workspace, "box", Grasp(DOWN, 0.03, 0.004))


@given(aside=st.floats(0.0, 0.02), side=st.sampled_from((-1.0, 1.0)))
@settings(max_examples=20, deadline=None)
def test_both_pads_have_to_meet_what_they_hold(aside, side):
    """One finger alone stops at a box that is not midway between them."""
    workspace = workspace_of(Object("box", Box((0.05, 0.03, 0.08)), Pose((0.0, 0.0, 0.04))))
    T_object_tool = Pose((0.0, side * aside, 0.0)) @ DOWN
    grasp = Grasp(T_object_tool, 0.03 + 2 * aside, 0.002)
    assert slips_off(workspace, "box", grasp) == (2 * aside > MET)
