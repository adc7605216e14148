from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.physics.righting import righted
from tamp.checking.physics.round_bodies.perching import perched
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Cylinder, Object, Pose, Sphere, Task


def tilted(size: tuple[float, float, float], tilt: float, under: float = 0.0) -> tuple[Scene, State]:
    """A box that stands on its lower right edge, on the table or on a block so high."""
    x, _, z = size
    up = z / 2 * np.cos(tilt) + x / 2 * np.sin(tilt) + under
    block = [Object("block", Box((0.2, 0.2, under)), Pose((0.0, 0.0, under / 2)))] if under else []
    task = Task("tilted", (Object("box", Box(size), Pose.from_rpy((0.0, 0.0, up), (0.0, tilt, 0.0))), *block))
    return Scene.of(task), State({o.name: o.pose.matrix for o in task.objects}, np.zeros(7))


@pytest.mark.parametrize("under", [0.0, 0.05])
@pytest.mark.parametrize(
    ("size", "tilt", "stays"),
    [
        ((0.05, 0.05, 0.1), 0.02, True),  # in PyBullet 1.4 mm
        ((0.05, 0.05, 0.1), 0.1, False),  # 6.6 mm
        ((0.02, 0.1, 0.12), 0.1, False),  # 9.8 mm
        ((0.03, 0.03, 0.03), 0.05, True),  # 1.3 mm
        ((0.1, 0.06, 0.03), 0.0, True),
    ],
)
def test_what_stands_tilted_rights_itself(size, tilt, stays, under):
    scene, state = tilted(size, tilt, under)
    assert (not list(perched(scene, state, "box", DEFAULT))) == stays


@given(tilt=st.floats(0.0, 0.1), down=st.floats(0.001, 0.01))
@settings(max_examples=30, deadline=None)
def test_what_comes_down_no_farther_than_it_may_is_let_do_so(tilt, down):
    scene, state = tilted((0.05, 0.05, 0.1), tilt)
    assert bool(list(perched(scene, state, "box", DEFAULT, down))) == (righted(scene, state, "box", DEFAULT) > down)


@given(tilt=st.floats(0.0, 0.1), wide=st.floats(0.02, 0.06), high=st.floats(0.02, 0.08))
@settings(max_examples=30, deadline=None)
def test_a_box_rights_itself_by_its_tilt(tilt, wide, high):
    scene, state = tilted((wide, 0.05, high), tilt)
    flat = tilted((wide, 0.05, high), 0.0)[1].poses["box"].copy()
    T = state.poses["box"]
    corner = T @ [wide / 2, 0.0, -high / 2, 1.0]
    flat[:3, 3] += corner[:3] - (flat @ [wide / 2, 0.0, -high / 2, 1.0])[:3]
    far = scene.displacement("box", T, flat)
    over_its_edge = wide / 2 * np.cos(tilt) - high / 2 * np.sin(tilt) < 5e-4
    if not over_its_edge and T[2, 3] - flat[2, 3] > 5e-4:
        assert righted(scene, state, "box", DEFAULT) == pytest.approx(far, abs=1e-6)


@pytest.mark.parametrize("shape", [Sphere(0.03), Cylinder(0.03, 0.1), Cylinder(0.03, 0.06)])
@pytest.mark.parametrize("turn", [0.0, np.pi / 2])
def test_what_is_round_lies_still(shape, turn):
    task = Task("round", (Object("box", shape, Pose.from_rpy((0.0, 0.0, 0.03), (turn, 0.3, 0.0))),))
    scene = Scene.of(task)
    T = task.objects[0].pose.matrix.copy()
    T[2, 3] -= (scene.solids["box"].hull.part.vertices @ T[2, :3] + T[2, 3]).min()
    if isinstance(shape, Sphere) or turn:
        assert righted(scene, State({"box": T}, np.zeros(7)), "box", DEFAULT) < DEFAULT.standing
