import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.formats.obj import box_obj
from tamp.streams.creeping import creeping
from tamp.streams.holding import creeps
from tamp.streams.squeezed import Squeezed
from tamp.streams.values import Grasp
from tamp.task import Box, Mesh, Object, Pose
from tests.streams.tables import workspace_of

DOWN = Pose.from_rpy((0, 0, 0), (np.pi, 0, 0))


def strip(folder, apart, half):
    """A thin board between two bars, one on each face; the bars are `apart` from facing each other [m]."""
    bars = [(-1, apart / 2), (1, -apart / 2)]
    text = box_obj("board", (-0.02, -half / 2, -0.03), (0.02, half / 2, 0.03))
    for number, (side, x) in enumerate(bars, 1):
        ys = sorted((0.0, side * half))
        bar = box_obj("bar", (x - 0.0015, ys[0], -0.03), (x + 0.0015, ys[1], 0.03))
        text += "\n".join(shifted(line, 8 * number) for line in bar.splitlines()) + "\n"
    (folder / "strip.obj").write_text(text)
    return Mesh(folder / "strip.obj")


def shifted(line, by):
    """The same line of an OBJ file behind `by` other vertices."""
    kind, *rest = line.split()
    return " ".join([kind, *(str(int(n) + by) for n in rest)]) if kind == "f" else line


def needed(shape, grasp, friction=0.5):
    workspace = workspace_of(Object("thing", shape, Pose((0.0, 0.1, 0.03)), friction=friction))
    return creeping(Squeezed(workspace, "thing", grasp)), creeps(workspace, "thing", grasp)


@given(x=st.floats(-0.02, 0.02), z=st.floats(-0.02, 0.02), width=st.floats(0.01, 0.06))
@settings(max_examples=20, deadline=None)
def test_parallel_faces_need_next_to_no_friction(x, z, width):
    grasp = Grasp(Pose((x, 0.0, z)) @ DOWN, width)
    assert needed(Box((0.06, width, 0.06)), grasp)[0] < 0.05


def test_bars_that_face_each_other_are_held(tmp_path):
    assert needed(strip(tmp_path, 0.0, 0.005), Grasp(DOWN, 0.01))[1] < 1.0


@pytest.mark.parametrize("half", [0.005, 0.01])
def test_bars_that_do_not_face_each_other_need_what_the_line_between_them_slants(tmp_path, half):
    few, _ = needed(strip(tmp_path, 0.0, half), Grasp(DOWN, 2 * half))
    more, _ = needed(strip(tmp_path, 0.01, half), Grasp(DOWN, 2 * half))
    assert more - few == pytest.approx(0.01 / (2 * half), rel=0.5)


def test_what_more_friction_holds_creeps_without_it(tmp_path):
    shape = strip(tmp_path, 0.01, 0.005)
    assert needed(shape, Grasp(DOWN, 0.01), friction=0.3)[1] > 1.0
    assert needed(shape, Grasp(DOWN, 0.01), friction=3.0)[1] < 1.0


def test_nothing_between_the_pads_needs_no_friction():
    assert needed(Box((0.02, 0.02, 0.02)), Grasp(Pose((0.1, 0.0, 0.0)) @ DOWN, 0.02))[0] == 0.0
