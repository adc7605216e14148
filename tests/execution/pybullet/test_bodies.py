from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pybullet
import pytest
import trimesh
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from tamp.execution.pybullet.bodies import Material, _drawn_in, create_body, eroded
from tamp.execution.simulators import make_simulator
from tamp.task import Box, Capsule, Cylinder, Inertia, Mesh, Object, Pose, Sphere, load_robot
from tamp.task.mesh.parts import convex_hull, parts
from tamp.world.robot.urdf import link_shapes

BOWL = Mesh(Path(__file__).parents[3] / "scenarios" / "objects" / "bowl" / "collision.obj")
SHAPES = (Box((0.04, 0.06, 0.1)), Cylinder(0.03, 0.1), Sphere(0.02), Capsule(0.02, 0.06), BOWL)


@pytest.fixture(scope="module")
def client():
    number = pybullet.connect(pybullet.DIRECT)
    pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=number)
    yield number
    pybullet.disconnect(physicsClientId=number)


@settings(max_examples=25, deadline=None)
@given(
    shape=st.sampled_from(SHAPES),
    xyz=st.tuples(*[st.floats(-0.5, 0.5)] * 3),
    rpy=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
)
def test_a_body_stands_where_it_was_put(client, shape, xyz, rpy):
    pose = Pose.from_rpy(xyz, rpy)
    with tempfile.TemporaryDirectory() as folder:
        body = create_body(client, Path(folder), shape, Material(0.1, 0.5), pose)
    assert np.allclose(body.pose(client).matrix, pose.matrix, atol=1e-9)
    body.place(client, Pose())
    assert np.allclose(body.pose(client).matrix, np.eye(4), atol=1e-9)
    pybullet.removeBody(body.id, physicsClientId=client)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_the_body_fills_the_space_of_its_parts(client, shape):
    pose = Pose.from_rpy((0.1, -0.2, 0.3), (0.4, 0.5, 0.6))
    with tempfile.TemporaryDirectory() as folder:
        body = create_body(client, Path(folder), shape, Material(0.1, 0.5), pose)
    points = np.concatenate([part.vertices for part in parts(shape)]) @ pose.matrix[:3, :3].T + pose.matrix[:3, 3]
    # From outside along each axis, a ray meets the body no earlier than its bounding box and a little inside it.
    for axis in range(3):
        start = points[points[:, axis].argmax()] * 0.999 + points.mean(axis=0) * 0.001
        start[axis] += 1.0
        end = start.copy()
        end[axis] -= 2.0
        ((hit, _, _, where, _),) = pybullet.rayTest(start, end, physicsClientId=client)
        assert hit == body.id
        assert where[axis] == pytest.approx(points[:, axis].max(), abs=0.003)
    pybullet.removeBody(body.id, physicsClientId=client)


def test_mass_lies_where_the_inertia_says(client):
    inertia = Inertia(Pose.from_rpy((0.01, -0.02, 0.03), (0.1, 0.2, 0.3)), (1e-4, 2e-4, 2.5e-4))
    pose = Pose.from_rpy((0.1, -0.2, 0.3), (0.4, 0.5, 0.6))
    with tempfile.TemporaryDirectory() as folder:
        body = create_body(client, Path(folder), SHAPES[0], Material(0.1, 0.5, inertia=inertia), pose)
    assert np.allclose(body.pose(client).matrix, pose.matrix, atol=1e-9)
    center, _ = pybullet.getBasePositionAndOrientation(body.id, physicsClientId=client)
    assert np.allclose(center, (pose @ inertia.frame).xyz, atol=1e-9)
    assert pybullet.getDynamicsInfo(body.id, -1, physicsClientId=client)[2] == pytest.approx(inertia.moments)
    pybullet.removeBody(body.id, physicsClientId=client)


def test_a_hollow_stays_hollow(client):
    with tempfile.TemporaryDirectory() as folder:
        body = create_body(client, Path(folder), BOWL, Material(0.1, 0.5), Pose())
    ((hit, _, _, where, _),) = pybullet.rayTest((0, 0, 0.5), (0, 0, -0.5), physicsClientId=client)
    top = max(part.vertices[:, 2].max() for part in parts(BOWL))
    assert hit == body.id
    assert where[2] < top - 0.02
    pybullet.removeBody(body.id, physicsClientId=client)


def test_mass_properties_are_those_of_the_shape(client):
    box = Box((0.1, 0.2, 0.3))
    with tempfile.TemporaryDirectory() as folder:
        body = create_body(client, Path(folder), box, Material(0.6, 0.5), Pose())
    info = pybullet.getDynamicsInfo(body.id, -1, physicsClientId=client)
    a, b, c = (side**2 for side in box.size)
    assert info[0] == pytest.approx(0.6)
    assert sorted(info[2]) == pytest.approx(sorted([0.05 * (b + c), 0.05 * (a + c), 0.05 * (a + b)]))
    pybullet.removeBody(body.id, physicsClientId=client)


SPLIT = [(0.0, 0.0, 0.0), (0.0, 0.0, 0.016), (0.0, 2e-16, 0.008), (0.0, -0.016, 0.0), (0.016, 0.0, 0.0)]


@example(points=SPLIT, margin=0.0007)  # two of its faces are in one plane, but for rounding
@given(
    points=st.lists(st.tuples(*[st.floats(-0.03, 0.03)] * 3), min_size=6, max_size=20),
    margin=st.floats(0.0001, 0.002),
)
def test_drawn_in_face_by_face_a_part_has_every_face_that_far_inside(points, margin):
    try:
        part = convex_hull(np.array(points))
    except ValueError:
        assume(False)
    a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    assume(areas.min() > 1e-6)
    normals /= areas[:, None]
    thick = np.einsum("ij,ij->i", normals, a - part.vertices.mean(axis=0)).min()
    assume(thick > 2.5 * margin)
    reach = (normals @ eroded(part, margin).vertices.T).max(axis=1)
    assert (reach <= np.einsum("ij,ij->i", normals, a) - margin + 1e-7).all()


def slanted_brick(slant, sides=(0.28, 0.037, 0.15)):
    """A brick whose broad sides lean: what stands on its narrow side has its centre of mass beside the middle."""
    x, y, z = (np.array(corner) for corner in zip(*np.ndindex(2, 2, 2), strict=True))
    return convex_hull(np.stack([sides[0] * x, sides[1] * y + slant * sides[2] * z, sides[2] * z], axis=1))


@given(slant=st.floats(-0.5, 0.5), margin=st.floats(0.0002, 0.002))
def test_the_faces_of_a_slanted_brick_stay_level_when_they_are_drawn_in(slant, margin):
    part = slanted_brick(slant)
    drawn = _drawn_in(part, margin)
    a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    for face, normal in zip(part.faces, normals, strict=True):
        inside = (part.vertices[face] - drawn[face]) @ normal
        assert inside == pytest.approx([margin] * 3, abs=0.01 * margin)


@pytest.mark.parametrize("slant", [-0.16, 0.16])
def test_a_slanted_brick_stands_where_its_centre_of_mass_is_over_its_base(slant, tmp_path):
    part = slanted_brick(slant)
    mesh = trimesh.Trimesh(part.vertices, part.faces, process=False)
    mesh.export(tmp_path / "brick.obj")
    brick = Object("brick", Mesh(tmp_path / "brick.obj"), Pose((0.1, 0.1, 0.0)))
    with make_simulator("pybullet", [brick], {}) as world:
        world.step(480)
        assert world.poses()["brick"].matrix[2, 2] > 0.9999


def test_a_finger_s_pad_stays_flat_when_it_is_drawn_in():
    """Shrunk along the axes of its vertices' cloud, a pad was tilted by half a millimetre and stuck out by as much."""
    spec = load_robot("panda")
    hull = next(shape.hull for shape in link_shapes(spec) if shape.link == spec.gripper.fingers[0])
    drawn = eroded(hull, 0.001).vertices
    pad, before = drawn[drawn[:, 1] < 0.0012], hull.vertices[hull.vertices[:, 1] < 0.0005]
    assert np.ptp(pad[:, 0]) > 0.8 * np.ptp(before[:, 0])
    assert pad[:, 1].min() - before[:, 1].min() == pytest.approx(0.001, abs=5e-5)
    assert np.ptp(pad[:, 1]) < 0.0002


def test_what_is_thin_keeps_half_of_its_thickness():
    sheet = parts(Box((0.1, 0.1, 0.001)))[0]
    assert np.ptp(eroded(sheet, 0.001).vertices, axis=0) == pytest.approx([0.0995, 0.0995, 0.0005])
