"""The two renderers see the same, and what they see is where it is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import ndimage

from tamp.errors import RobotError, TampError
from tamp.perception.cameras.camera import Camera, Intrinsics
from tamp.perception.rendering.backends import open_renderer
from tamp.perception.rendering.renderer import Picture
from tamp.perception.rendering.robot import camera_pose, link_pose
from tamp.perception.rendering.scene import Body, robot_body, table_body
from tamp.perception.rendering.surface import Surface, plain
from tamp.task import Box, Cylinder, Pose, Table, load_robot
from tamp.world.robot.model import robot_model

pytest.importorskip("embreex", reason="the extra perception is not installed")

K = Intrinsics.from_field_of_view(320, 240, math.radians(50))
BACKENDS = ("raycast", "software")


def _looking_down(x: float, y: float, z: float) -> np.ndarray:
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[:3, 3] = x, y, z
    return T


def _tilted() -> np.ndarray:
    return (Pose((1.0, 0.1, 0.7)) @ Pose.from_rpy((0, 0, 0), (math.radians(-118), 0, math.radians(92)))).matrix


def _bodies() -> list[Body]:
    panda = load_robot("panda")
    box = plain(Box((0.1, 0.06, 0.2)), (200, 30, 30))
    can = plain(Cylinder(0.03, 0.12), (30, 60, 200))
    return [
        table_body(Table()),
        robot_body(panda, (-2.0, *panda.home[1:])),  # out of the way
        Body("box", box, Pose.from_rpy((0.1, 0.2, 0.1), (0, 0, 0.4)).matrix),
        Body("can", can, Pose.from_rpy((0.05, -0.2, 0.03), (math.pi / 2, 0, 0.3)).matrix),
    ]


def _picture(backend: str, bodies: list[Body], T: np.ndarray) -> Picture:
    with open_renderer(backend)(bodies) as scene:
        return scene.picture(K, T)


@pytest.mark.parametrize("T", [_looking_down(0.0, 0.0, 0.9), _tilted()], ids=["above", "tilted"])
def test_the_renderers_agree(T: np.ndarray) -> None:
    a, b = (_picture(backend, _bodies(), T) for backend in BACKENDS)
    assert {0, 1, 2, 3} <= set(np.unique(a.bodies)), "table, robot and both objects are in the picture"
    low, high = ndimage.minimum_filter(a.bodies, 3), ndimage.maximum_filter(a.bodies, 3)
    inner = (low == high) & (a.bodies >= 0)
    assert (a.bodies == b.bodies)[inner].mean() > 0.999
    assert (np.abs(a.depth - b.depth)[inner] < 1e-3).mean() > 0.99
    off = np.abs(a.color.astype(int) - b.color.astype(int)).max(axis=2)[inner]
    assert np.percentile(off, 95) <= 12


@pytest.mark.parametrize("backend", BACKENDS)
def test_depth_and_place_of_a_box_seen_from_above(backend: str) -> None:
    box = Body("box", plain(Box((0.2, 0.1, 0.1)), (250, 0, 0)), Pose((0.1, 0.05, 0.05)).matrix)
    picture = _picture(backend, [table_body(Table()), box], _looking_down(0.0, 0.0, 1.0))
    points = K.points(picture.depth)[picture.bodies == 1] @ _looking_down(0, 0, 1)[:3, :3].T + (0, 0, 1)
    assert points[:, 2].max() == pytest.approx(0.1, abs=1e-3)
    top = points[points[:, 2] > 0.099]
    assert top.min(axis=0)[:2] == pytest.approx([0.0, 0.0], abs=4e-3)
    assert top.max(axis=0)[:2] == pytest.approx([0.2, 0.1], abs=4e-3)
    assert picture.color[picture.bodies == 1][:, 0].min() > 100
    assert (picture.slant[picture.bodies == 0] > 0.8).mean() > 0.95


def test_the_renderers_agree_on_triangles_that_are_inside_out() -> None:
    """Scanned meshes have such; where one renderer left them out, what is behind them would be seen."""
    box = plain(Box((0.2, 0.1, 0.1)), (250, 120, 0))
    some = np.arange(len(box.faces)) % 2 == 0
    faces = np.where(some[:, None], box.faces[:, ::-1], box.faces)
    bodies = [Body("box", Surface(box.vertices, faces, box.colors), Pose((0.1, 0.05, 0.05)).matrix)]
    a, b = (_picture(backend, bodies, _looking_down(0.0, 0.0, 1.0)) for backend in BACKENDS)
    inner = ndimage.binary_erosion(a.bodies == 0)
    assert inner.sum() > 500
    assert np.abs(a.depth - b.depth)[inner].max() < 1e-3
    assert np.abs(a.color.astype(int) - b.color.astype(int))[inner].max() <= 12


@pytest.mark.parametrize("backend", BACKENDS)
def test_nothing_is_black_and_without_depth(backend: str) -> None:
    box = Body("box", plain(Box((0.05, 0.05, 0.05))), np.eye(4))
    picture = _picture(backend, [box], _looking_down(0.0, 0.0, 1.0))
    empty = picture.bodies < 0
    assert 0.9 < empty.mean() < 1.0
    assert not picture.depth[empty].any()
    assert not picture.color[empty].any()


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_colour_a_corner(backend: str) -> None:
    box = plain(Box((0.4, 0.4, 0.02)))
    colors = np.where(box.vertices[:, :1] > 0, (255, 0, 0), (0, 0, 255)).astype(np.uint8)
    striped = Body("sheet", Surface(box.vertices.copy(), box.faces.copy(), colors), np.eye(4))
    picture = _picture(backend, [striped], _looking_down(0.0, 0.0, 0.8))
    red = picture.color[:, :, 0].astype(int) - picture.color[:, :, 2]
    rows, columns = np.nonzero(picture.bodies == 0)
    assert np.corrcoef(columns, red[rows, columns])[0, 1] > 0.5


def test_a_link_is_where_the_robot_has_it() -> None:
    panda = load_robot("panda")
    T = link_pose(robot_model(panda), panda.tool_parent, panda.home, 0.08) @ panda.T_parent_tool.matrix
    assert np.allclose(T, robot_model(panda).forward(np.array(panda.home)))


def test_a_link_that_is_not_there_is_refused() -> None:
    camera = Camera("c", K, "panda_link99", Pose())
    panda = load_robot("panda")
    with pytest.raises(RobotError, match="there is no link 'panda_link99'; the URDF has"):
        camera_pose(camera, panda, panda.home)


def test_an_unknown_renderer_is_refused() -> None:
    with pytest.raises(TampError, match="unknown renderer 'vulkan'; valid are raycast, software"):
        open_renderer("vulkan")
