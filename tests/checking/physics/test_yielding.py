"""How stacks give way whose bodies hold each other up: followed from rest until they touch anew.

The scenes are ones that random search has found (`benchmarks.stacks`): PyBullet and MuJoCo both let them rest until the
change, and then let something go by 2 cm at least, or for ever.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking.actions.left_standing import check_rest, check_uncovered
from tamp.checking.physics.least_squares import nnls
from tamp.checking.physics.yielding import slump
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.task import Box, Cylinder, Object, Pose, Sphere, Task

TAKEN = {
    "two slabs that lie on each other and on what is taken": (
        Object(
            "it",
            Box((0.04574, 0.02024, 0.02619)),
            Pose.from_rpy((-0.02079, -0.09574, 0.01308), (1e-05, 5e-05, -0.01853)),
            mass=0.328,
            friction=0.5,
        ),
        Object(
            "o1",
            Box((0.21923, 0.06677, 0.02589)),
            Pose.from_rpy((-0.06787, -0.07671, 0.03651), (0.00087, 0.21994, 1.76512)),
            mass=0.031,
            friction=1.0,
        ),
        Object(
            "o2",
            Box((0.235, 0.11768, 0.01951)),
            Pose.from_rpy((0.04469, 0.06215, 0.02768), (-0.22392, 0.04373, 0.11225)),
            mass=0.111,
            friction=0.3,
        ),
        Object(
            "o3",
            Box((0.03983, 0.04764, 0.05371)),
            Pose.from_rpy((-0.14308, -0.06663, 0.01991), (-0.01495, -1.57077, -0.10646)),
            mass=0.216,
            friction=1.0,
        ),
        Object(
            "o4",
            Box((0.227, 0.09135, 0.01505)),
            Pose.from_rpy((0.02354, 0.05972, 0.04635), (-0.22789, -0.0094, -0.11792)),
            mass=0.039,
            friction=1.0,
        ),
        Object(
            "o5",
            Box((0.13494, 0.06746, 0.01214)),
            Pose.from_rpy((-0.21368, -0.13805, 0.00605), (3.1414, -0.0, 2.25715)),
            mass=0.649,
            friction=0.5,
        ),
    ),
    "two slabs that lean on each other": (
        Object(
            "it",
            Box((0.02494, 0.04237, 0.02641)),
            Pose.from_rpy((0.06366, 0.04105, 0.01319), (0.00011, 3e-05, 1.43065)),
            mass=0.096,
            friction=0.3,
        ),
        Object(
            "o1",
            Box((0.04224, 0.04943, 0.02026)),
            Pose.from_rpy((0.00277, 0.08986, 0.01012), (-6e-05, 0.0, -3e-05)),
            mass=0.400,
            friction=0.3,
        ),
        Object(
            "o3",
            Box((0.24135, 0.05128, 0.02459)),
            Pose.from_rpy((0.09787, -0.04299, 0.0238), (-0.54536, 1e-05, 2.52471)),
            mass=0.055,
            friction=1.0,
        ),
        Object(
            "o4",
            Box((0.11259, 0.09946, 0.01142)),
            Pose.from_rpy((0.00809, -0.06195, 0.02235), (-0.20489, -0.1205, 2.3239)),
            mass=0.057,
            friction=0.3,
        ),
        Object(
            "o5",
            Cylinder(0.02849, 0.06529),
            Pose.from_rpy((-0.00076, 0.09873, 0.05288), (0.00028, 4e-05, 2.77404)),
            mass=0.412,
            friction=0.5,
        ),
    ),
    "a slab that stands against a can": (
        Object(
            "it",
            Cylinder(0.02490, 0.05820),
            Pose.from_rpy((-0.02131, 0.06615, 0.02489), (1.57078, 0.67864, 1.56716)),
            mass=0.396,
            friction=0.3,
        ),
        Object(
            "o1",
            Box((0.04639, 0.0444, 0.04205)),
            Pose.from_rpy((-0.025, 0.11857, 0.02101), (1e-05, 0.0, 1.71198)),
            mass=0.819,
            friction=1.0,
        ),
        Object(
            "o2",
            Box((0.10784, 0.08752, 0.01714)),
            Pose.from_rpy((0.00358, 0.01194, 0.03686), (-0.00802, -0.57655, 2.25718)),
            mass=0.142,
            friction=0.8,
        ),
        Object(
            "o3",
            Cylinder(0.03154, 0.04008),
            Pose.from_rpy((0.08729, 0.03616, 0.03153), (1.57078, -0.47608, -0.00729)),
            mass=1.446,
            friction=0.8,
        ),
    ),
    "a card that stands, held by a can that lies": (
        Object(
            "it",
            Cylinder(0.02937, 0.09911),
            Pose.from_rpy((-0.00015, 0.09836, 0.02936), (1.57079, -0.16869, -0.00079)),
            mass=0.192,
            friction=1.0,
        ),
        Object(
            "o1",
            Cylinder(0.01664, 0.11795),
            Pose.from_rpy((0.15269, 0.12605, 0.01657), (1.5743, 1.25419, -1.44308)),
            mass=0.034,
            friction=0.5,
        ),
        Object(
            "o2",
            Box((0.00671, 0.06477, 0.08912)),
            Pose.from_rpy((0.07379, 0.14743, 0.02593), (1.58503, 0.77494, 2.19251)),
            mass=0.152,
            friction=0.8,
        ),
        Object(
            "o3",
            Box((0.04208, 0.05734, 0.03447)),
            Pose.from_rpy((-0.01366, -0.06228, 0.01723), (-0.0, -1e-05, 0.02466)),
            mass=0.528,
            friction=0.5,
        ),
        Object(
            "o4",
            Box((0.22363, 0.04268, 0.01213)),
            Pose.from_rpy((0.14856, 0.1654, 0.03092), (-0.02944, 0.21998, 1.56556)),
            mass=0.665,
            friction=0.3,
        ),
    ),
}
PUT = {
    "a can on a slab that slopes by a degree": (
        Object(
            "o0",
            Box((0.19373, 0.11352, 0.01093)),
            Pose.from_rpy((0.05038, -0.06146, 0.00544), (-0.00012, 9e-05, 1.57037)),
            mass=0.049,
            friction=0.8,
        ),
        Object(
            "o1",
            Box((0.01733, 0.07119, 0.1439)),
            Pose.from_rpy((0.13393, -0.08686, 0.01661), (3.13985, 1.45933, 3.1401)),
            mass=0.049,
            friction=0.3,
        ),
        Object(
            "o2",
            Cylinder(0.02367, 0.09626),
            Pose.from_rpy((-0.02489, -0.15143, 0.0315), (1.81872, -0.78415, -1.75882)),
            mass=0.041,
            friction=0.3,
        ),
        Object(
            "o4",
            Box((0.0125, 0.05981, 0.19287)),
            Pose.from_rpy((-0.04645, 0.07318, 0.00624), (-0.8117, 1.57077, 0.86689)),
            mass=0.216,
            friction=0.8,
        ),
        Object(
            "o5",
            Box((0.12313, 0.06032, 0.02721)),
            Pose.from_rpy((0.01259, -0.02271, 0.0255), (0.03364, -0.0001, 0.97501)),
            mass=0.077,
            friction=0.3,
        ),
        Object(
            "it",
            Cylinder(0.02828, 0.09980),
            Pose.from_rpy((-0.00638, -0.03004, 0.06849), (1.5708, -0.0, 1.5708)),
            mass=0.121,
            friction=0.8,
        ),
    ),
    "a can over the edge of a slab that slopes": (
        Object(
            "o0",
            Sphere(0.01528),
            Pose.from_rpy((0.03534, -0.00262, 0.01526), (-0.00901, -0.02137, 0.00168)),
            mass=0.054,
            friction=1.0,
        ),
        Object(
            "o1",
            Sphere(0.02855),
            Pose.from_rpy((-0.00102, -0.09882, 0.02854), (0.05682, 0.05939, 1.57176)),
            mass=0.335,
            friction=1.0,
        ),
        Object(
            "o2",
            Box((0.19403, 0.10857, 0.01437)),
            Pose.from_rpy((0.08424, -0.01947, 0.03188), (0.03503, 0.24013, 0.85196)),
            mass=0.963,
            friction=1.0,
        ),
        Object(
            "o3",
            Box((0.01328, 0.03766, 0.13595)),
            Pose.from_rpy((-0.02247, -0.18866, 0.06796), (0.00017, 0.00067, 1e-05)),
            mass=1.124,
            friction=0.3,
        ),
        Object(
            "it",
            Cylinder(0.02610, 0.11848),
            Pose.from_rpy((0.01074, -0.07497, 0.08883), (1.5708, -0.0, 1.84679)),
            mass=0.060,
            friction=0.5,
        ),
    ),
    "a domino beside a ball that it does not touch": (
        Object(
            "o0",
            Sphere(0.02102),
            Pose.from_rpy((-0.03809, 0.07643, 0.02101), (0.63644, -0.29063, 0.3403)),
            mass=0.129,
            friction=1.0,
        ),
        Object(
            "o1",
            Box((0.16443, 0.10657, 0.01246)),
            Pose.from_rpy((-0.02261, 0.1646, 0.00622), (-0.0, -0.0, -0.0127)),
            mass=0.153,
            friction=0.5,
        ),
        Object(
            "o2",
            Cylinder(0.01153, 0.08726),
            Pose.from_rpy((0.10374, -0.0196, 0.04362), (-0.00036, 0.00078, -1e-05)),
            mass=0.211,
            friction=1.0,
        ),
        Object(
            "it",
            Box((0.01912, 0.04338, 0.09086)),
            Pose.from_rpy((-0.02791, 0.10849, 0.05798), (0.0, -0.0, 1.5708)),
            mass=0.326,
            friction=0.8,
        ),
    ),
    "a column on the top of a ball": (
        Object(
            "o0",
            Box((0.0497, 0.05436, 0.05747)),
            Pose.from_rpy((-0.02119, -0.08383, 0.02873), (0.0, -0.0, 1.573)),
            mass=0.031,
            friction=1.0,
        ),
        Object(
            "o1",
            Box((0.16932, 0.06404, 0.01022)),
            Pose.from_rpy((-0.115, -0.08167, 0.0051), (3.14159, -0.0, 1.57226)),
            mass=0.241,
            friction=0.3,
        ),
        Object(
            "o2",
            Box((0.02262, 0.04194, 0.15585)),
            Pose.from_rpy((0.022, 0.03394, 0.02096), (-1.57079, 0.00052, -0.13662)),
            mass=0.217,
            friction=0.8,
        ),
        Object(
            "o3",
            Sphere(0.03204),
            Pose.from_rpy((0.10403, 0.06858, 0.03203), (0.0, 0.0, 1.5708)),
            mass=0.100,
            friction=1.0,
        ),
        Object(
            "o4",
            Box((0.03822, 0.02868, 0.04677)),
            Pose.from_rpy((0.03137, 0.08344, 0.0653), (0.00029, -0.00035, 2.35317)),
            mass=0.437,
            friction=0.3,
        ),
        Object(
            "o5",
            Box((0.00855, 0.05484, 0.13371)),
            Pose.from_rpy((-0.02845, 0.12184, 0.06683), (2e-05, 0.0003, 1.5708)),
            mass=0.081,
            friction=0.5,
        ),
        Object(
            "it",
            Cylinder(0.01514, 0.09364),
            Pose.from_rpy((0.07192, 0.07356, 0.10577), (0.0, -0.0, 2.42442)),
            mass=0.281,
            friction=0.3,
        ),
    ),
}


def said(check, objects: tuple[Object, ...]) -> list[str]:
    """What the checker says when "it" has come to its place, or is taken away."""
    scene, sentences = Scene.of(Task("given", objects)), list[str]()
    state = State({o.name: o.pose.matrix for o in objects}, np.zeros(7))
    check(scene, state, "it", DEFAULT, lambda kind, sentence, **_: sentences.append(sentence))
    return sentences


def slumped(*objects: Object, most: float = 0.1) -> dict[str, float]:
    """How far a stack gives way, of which the first object is one."""
    scene = Scene.of(Task("given", objects))
    state = State({o.name: o.pose.matrix for o in objects}, np.zeros(7))
    return slump(scene, state, objects[0].name, most, replace(DEFAULT, standing=DEFAULT.touching))


def turned(objects: tuple[Object, ...], yaw: float) -> tuple[Object, ...]:
    """All of it turned about the vertical."""
    turn = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, yaw))
    return tuple(replace(o, pose=turn @ o.pose) for o in objects)


@pytest.mark.parametrize("title", TAKEN)
def test_what_leans_on_each_other_gives_way_when_one_is_taken(title):
    assert any("gives way" in sentence for sentence in said(check_uncovered, TAKEN[title]))


@pytest.mark.parametrize("title", PUT)
def test_what_is_put_on_what_does_not_hold_it_goes_on(title):
    assert said(check_rest, PUT[title])


@given(yaw=st.floats(-3.0, 3.0), slope=st.floats(0.015, 0.2), radius=st.floats(0.015, 0.03), lying=st.booleans())
@settings(max_examples=25, deadline=None)
def test_what_is_round_rolls_down_the_least_slope(yaw, slope, radius, lying):
    slab = Object("slab", Box((0.2, 0.12, 0.02)), Pose.from_rpy((0.0, 0.0, 0.05), (0.0, slope, 0.0)), mass=1.0)
    foot = Object("foot", Box((0.2, 0.12, 0.01)), Pose((0.0, 0.0, 0.005)), mass=1.0)
    at = np.array([0.0, 0.0, 0.05]) + (0.01 + radius) * np.array([np.sin(slope), 0.0, np.cos(slope)])
    shape = Cylinder(radius, 0.06) if lying else Sphere(radius)
    ball = Object("it", shape, Pose.from_rpy(tuple(at), (np.pi / 2 * lying, 0.0, 0.0)), mass=0.2)
    assert any("rolls down" in sentence for sentence in said(check_rest, turned((slab, foot, ball), yaw)))


@given(yaw=st.floats(-3.0, 3.0), radius=st.floats(0.015, 0.03), x=st.floats(-0.05, 0.05), mass=st.floats(0.02, 1.0))
@settings(max_examples=25, deadline=None)
def test_what_is_round_stays_on_what_is_level_and_not_much_lighter(yaw, radius, x, mass):
    slab = Object("slab", Box((0.2, 0.12, 0.02)), Pose((0.0, 0.0, 0.01)), mass=mass)
    ball = Object("it", Sphere(radius), Pose((x, 0.0, 0.02 + radius)), mass=0.2)
    sentences = said(check_rest, turned((slab, ball), yaw))
    assert bool(sentences) == (mass < 0.01), sentences


def test_what_rolls_does_not_stay_on_what_is_lighter_by_far():
    slab = Object("slab", Box((0.1, 0.06, 0.06)), Pose((0.0, 0.0, 0.03)), mass=0.03)
    ball = Object("it", Sphere(0.03), Pose((0.02, 0.0, 0.09)), mass=1.2)
    assert any("lighter" in sentence for sentence in said(check_rest, (slab, ball)))


@given(yaw=st.floats(-3.0, 3.0), count=st.integers(1, 4), seed=st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_what_stands_level_gives_way_by_nothing(yaw, count, seed):
    rng, high, objects = np.random.default_rng(seed), 0.0, list[Object]()
    for index in range(count):
        size = tuple(float(edge) for edge in rng.uniform(0.03, 0.06, 3))
        aside = rng.uniform(-0.002, 0.002, 2)
        pose = Pose((float(aside[0]), float(aside[1]), high + size[2] / 2))
        objects.append(Object(f"o{index}", Box(size), pose, mass=float(rng.uniform(0.05, 1.0))))
        high += size[2]
    assert max(slumped(*turned(tuple(objects), yaw)).values()) < 0.001


@given(yaw=st.floats(-3.0, 3.0), drop=st.floats(0.002, 0.03))
@settings(max_examples=20, deadline=None)
def test_what_hangs_in_the_air_comes_down_to_what_is_under_it(yaw, drop):
    box = Object("box", Box((0.05, 0.05, 0.05)), Pose((0.0, 0.0, 0.025 + drop)))
    assert slumped(*turned((box,), yaw))["box"] == pytest.approx(drop, abs=0.001)


@given(yaw=st.floats(-3.0, 3.0), lean=st.one_of(st.floats(0.02, 0.08), st.floats(0.18, 0.5)))
@settings(max_examples=20, deadline=None)
def test_a_board_that_nothing_holds_lies_down(yaw, lean):
    board = Box((0.02, 0.1, 0.2))
    z = (0.2 * np.cos(lean) + 0.02 * np.sin(lean)) / 2
    thing = Object("board", board, Pose.from_rpy((0.0, 0.0, float(z)), (0.0, lean, 0.0)), friction=1.0)
    falls = np.tan(lean) > 0.02 / 0.2
    assert (slumped(*turned((thing,), yaw), most=0.03)["board"] > 0.03) == falls


@given(rows=st.integers(1, 30), columns=st.integers(1, 120), seed=st.integers(0, 10_000), depend=st.booleans())
@settings(max_examples=60, deadline=None)
def test_non_negative_least_squares_are_where_nothing_more_is_gained(rows, columns, seed, depend):
    """Karush, Kuhn and Tucker's conditions, also where columns are each other's sums."""
    rng = np.random.default_rng(seed)
    A, b = rng.normal(size=(rows, columns)), rng.normal(size=rows)
    if depend:
        A[:, columns // 2 :] = A[:, : columns - columns // 2] @ rng.uniform(0.0, 1.0, (columns - columns // 2,) * 2)
    x, far = nnls(A, b)
    left = b - A @ x
    gain = A.T @ left / np.maximum(np.linalg.norm(A, axis=0), 1e-12)
    assert (x >= 0.0).all() and far == pytest.approx(np.linalg.norm(left), abs=1e-9)
    assert gain.max() < 1e-7 and np.abs(gain[x > 0.0]).max(initial=0.0) < 1e-6
