from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.checking import check
from tamp.checking.actions.collisions import blow
from tamp.checking.actions.fall import _turn, _turned, check_fall
from tamp.checking.geometry.solids import Solid
from tamp.checking.geometry.transforms import rotation, tilt
from tamp.checking.physics.support import carriers
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.execution.settling.settle import let_fall
from tamp.streams.affordances.tilts import rolls, tips_on
from tamp.task import Box, Fall, Mesh, Object, Pose, Task, load_robot
from tamp.task.mesh.parts import convex_hull, parts
from tamp.task.model import Table
from tests.checking.judging import assert_wrong_and_rejected
from tests.checking.mutations import FALLS
from tests.planned import planned
from tests.streams.tables import workspace_of

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


@pytest.fixture(scope="module")
def task():
    return planned("lay_book", 0)[0]


@pytest.fixture(scope="module")
def plan():
    return planned("lay_book", 0)[1]


def with_fall(plan, fall):
    """The plan with another step, or none, in place of its fall."""
    actions = tuple(
        replace(a, steps=tuple(new for s in a.steps if (new := fall if isinstance(s, Fall) else s) is not None))
        for a in plan.actions
    )
    return replace(plan, actions=actions)


def fallen(plan):
    return next(s for a in plan.actions for s in a.steps if isinstance(s, Fall))


def said(task, plan):
    return " ".join(p.sentence for p in check(task, plan, start=dict(plan.start)).problems if p.kind != "goal")


def test_a_book_laid_on_its_edge_falls_flat(task, plan):
    assert plan.actions[-1].name == "lay"
    assert check(task, plan).accepted


@given(seed=st.integers(0, 2**32 - 1), angle=st.one_of(st.floats(0.01, np.pi), st.just(np.pi)))
@settings(max_examples=60, deadline=None)
def test_a_turn_takes_a_pose_to_the_other_about_a_unit_axis(seed, angle):
    axis = np.random.default_rng(seed).normal(size=3)
    axis /= np.linalg.norm(axis)
    before, after = np.eye(4), np.eye(4)
    after[:3, :3] = rotation(axis, angle)
    found, turned = _turn(before, after)
    assert np.linalg.norm(found) == pytest.approx(1.0)
    np.testing.assert_allclose(rotation(found, turned), after[:3, :3], atol=1e-7)
    np.testing.assert_allclose(_turned(before, after)[-1], after, atol=1e-7)


@pytest.mark.parametrize("pose", [Pose((0.0, 0.0, -1e6)), Pose.from_rpy((1e6, 0.0, 0.0), (np.pi, 0.0, 0.0))])
def test_a_fall_from_beyond_all_bounds_is_refused_and_not_followed(task, plan, pose):
    assert "so far that nobody can look" in said(task, with_fall(plan, replace(fallen(plan), pose=pose)))


def test_a_fall_does_not_carry_an_object_elsewhere(task, plan):
    fall = fallen(plan)
    beside = Pose((0.05, 0.0, 0.0)) @ fall.pose
    assert "is said to slide" in said(task, with_fall(plan, replace(fall, pose=beside)))


@pytest.mark.parametrize(
    ("slid", "friction", "possible"),
    [
        *((0.0, 0.01, True), (0.015, 0.01, True), (0.029, 0.01, True), (0.05, 0.01, False), (-0.02, 0.01, False)),
        *((0.0, 0.5, True), (0.01, 0.5, True), (0.028, 0.5, False), (0.015, 1.0, False)),
    ],
)
def test_an_edge_slides_from_the_side_that_is_up_and_as_far_as_friction_lets_it(slid, friction, possible):
    length, height, tilt = 0.09, 0.06, np.radians(40.0)
    pivot, flat = Pose((0.1, 0.2, 0.0)), Pose((length / 2, 0.0, height / 2))
    tilted = pivot @ Pose.from_rpy((0, 0, 0), (0, -tilt, 0)) @ flat
    assert pivot.xyz[0] + length / 2 - tilted.xyz[0] == pytest.approx(0.03, abs=1e-3)  # as far it slides on ice
    brick = Object("brick", Box((length, 0.12, height)), tilted, friction=friction)
    state = State({"brick": tilted.matrix}, np.array(load_robot("panda").home))
    found = []
    fall = Fall("brick", Pose((-slid, 0.0, 0.0)) @ pivot @ flat)
    check_fall(Scene.of(Task("ice", (brick,))), state, fall, DEFAULT, lambda kind, *told, **more: found.append(kind))
    assert ("fall" not in found) == possible


def test_a_fall_does_not_turn_an_object_about_the_vertical(task, plan):
    fall = fallen(plan)
    turned = replace(fall, pose=fall.pose @ Pose.from_rpy((0, 0, 0), (0, 0, 0.5)))
    assert "turn sideways" in said(task, with_fall(plan, turned))


def test_nothing_falls_up(task, plan):
    fall = fallen(plan)
    upright = replace(fall, pose=Pose((*fall.pose.xyz[:2], 0.1), (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))))
    assert "may not fall to that side" in said(task, with_fall(plan, upright))


def test_without_a_fall_a_tilted_book_does_not_stay(task, plan):
    problems = said(task, with_fall(plan, None))
    assert "drop nothing" in problems
    assert "tips over" in problems


def test_what_lies_where_an_object_falls_is_hit(task, plan):
    goal = plan.goals["book"]
    brick = Object("brick", Box((0.03, 0.03, 0.03)), Pose((goal.xyz[0], goal.xyz[1], 0.015)))
    crowded = replace(task, objects=(*task.objects, brick))
    known = replace(plan, start={**plan.start, "brick": brick.pose})
    assert "book falls" in said(crowded, known)
    assert "into brick" in said(crowded, known)


def test_an_object_may_fall_away_from_what_it_leans_on():
    tilt, height = np.radians(50.0), 0.06
    pivot, flat = Pose((0.1, 0.2, 0.0)), Pose((0.045, 0.0, height / 2))
    brick = Object("brick", Box((0.09, 0.12, height)), pivot @ Pose.from_rpy((0, 0, 0), (0, -tilt, 0)) @ flat)
    x, z = -0.8 * height * np.sin(tilt), 0.8 * height * np.cos(tilt) - 0.0015  # the end that rose slopes over it
    block = Object("block", Box((0.03, 0.03, z)), pivot @ Pose((x - 0.015, 0.0, z / 2)))
    scene = Scene.of(Task("lean", (brick, block)))
    state = State({o.name: o.pose.matrix for o in (brick, block)}, np.array(load_robot("panda").home))
    assert carriers(scene, state, "brick", DEFAULT).bodies == ("block", "table")
    found = []
    check_fall(scene, state, Fall("brick", pivot @ flat), DEFAULT, lambda *told, **more: found.append(told))
    assert not found


@pytest.fixture(scope="module")
def corner():
    return planned("drop_into_corner", 0)[0]


@pytest.fixture(scope="module")
def drop():
    return planned("drop_into_corner", 0)[1]


def moved(plan, x=0.0, z=0.0):
    """The plan whose fall is said to end elsewhere."""
    fall = fallen(plan)
    return with_fall(plan, replace(fall, pose=Pose((x, 0.0, z)) @ fall.pose))


def test_a_block_let_go_in_a_box_falls_straight_down(corner, drop):
    assert drop.actions[-1].name == "lay-on"
    assert check(corner, drop).accepted


def test_without_a_fall_a_block_does_not_stay_in_the_air(corner, drop):
    assert "stands in the air" in said(corner, with_fall(drop, None))


def test_a_falling_block_goes_neither_aside_nor_up_nor_too_far(corner, drop):
    assert "move 10 mm aside" in said(corner, moved(drop, x=0.01))
    assert "upwards" in said(corner, moved(drop, z=0.3))
    assert "nobody knows where it comes to rest" in said(corner, moved(drop, z=-0.2))
    assert "block falls" in said(corner, moved(drop, z=-0.02))


def test_a_falling_block_is_not_let_go_over_the_wall(corner, drop):
    brick = Object("brick", Box((0.02, 0.02, 0.01)), Pose((*drop.goals["block"].xyz[:2], 0.04)))
    crowded = replace(corner, objects=(*corner.objects, brick))
    assert "into brick" in said(crowded, replace(drop, start={**drop.start, "brick": brick.pose}))


@pytest.mark.parametrize("mutation", FALLS, ids=lambda mutation: mutation.__name__)
def test_a_corrupted_fall_is_wrong_and_rejected_for_its_own_reason(task, plan, mutation):
    assert_wrong_and_rejected(mutation(task, plan, np.random.default_rng(0)), FALLS[mutation])


def test_the_oracle_finds_nothing_wrong_with_a_valid_one(task, plan):
    pytest.importorskip("pinocchio")
    from tests.checking.oracle import wrong

    assert wrong(task, plan) is None


@pytest.mark.parametrize("slid, possible", [(0.0, True), (0.01, True), (-0.012, False), (0.06, False)])
def test_what_has_a_round_edge_rolls_over_it(slid, possible):
    radius, tilt = 0.05, np.radians(50.0)
    angles = np.linspace(0.0, np.pi / 2, 40)
    side = np.array([(-radius * np.sin(a), radius - radius * np.cos(a)) for a in angles])  # from below to the left
    section = np.vstack([side, [(0.06, 0.0), (0.06, radius)]])
    hull = convex_hull(np.array([(x, y, z) for x, z in section for y in (-0.04, 0.04)]))
    flat = Pose((0.1 - slid, 0.2, 0.0))
    rolled = Pose((0.1 - radius * tilt, 0.2, radius)) @ Pose.from_rpy((0, 0, 0), (0, -tilt, 0)) @ Pose((0, 0, -radius))
    scene = Scene.of(Task("round", (Object("round", Box((0.1, 0.08, 0.05)), rolled),)))
    scene = replace(scene, solids={**scene.solids, "round": Solid.of("round", (hull,))})
    state = State({"round": rolled.matrix}, np.array(load_robot("panda").home))
    found = []
    check_fall(scene, state, Fall("round", flat), DEFAULT, lambda kind, *told, **more: found.append((kind, *told)))
    assert not [each for each in found if each[0] == "fall"] or not possible
    assert any("is said to slide" in sentence for _, sentence in found) != possible


@pytest.mark.parametrize("heavy", [False, True])
def test_a_blow_on_a_wall_of_bricks_is_followed_once_over_each_contact_with_each_mass(monkeypatch, heavy):
    rows, brick = 5, (0.02, 0.06, 0.02)
    bricks = {
        f"{row}.{i}": Pose((0.0, 0.062 * (i - row / 2), 0.02 * (rows - row) - 0.01))
        for row in range(rows)
        for i in range(row + 1)
    }
    contacts = {(f"{row}.{i}", f"{row + 1}.{j}") for row in range(rows - 1) for i in range(row + 1) for j in (i, i + 1)}
    masses = dict.fromkeys(bricks, 0.1) | {"1.0": 0.3 if heavy else 0.1}
    objects = (Object(name, Box(brick), pose, mass=masses[name]) for name, pose in bricks.items())
    scene = Scene.of(Task("wall", tuple(objects)))
    state = State({name: pose.matrix for name, pose in bricks.items()}, np.array(load_robot("panda").home))
    state.poses["0.0"] = Pose((0.0, 0.0, 0.02 * rows + 0.02)).matrix
    followed, found = [], []

    def noted(scene, state, each, allow, goes_on=blow._struck):
        followed.append((*each.bodies[-2:], round(each.mass, 3)))
        return goes_on(scene, state, each, allow)

    monkeypatch.setattr(blow, "_struck", noted)
    check_fall(scene, state, Fall("0.0", bricks["0.0"]), DEFAULT, lambda *told, **more: found.append(told))
    assert not found
    assert len(followed) == len(set(followed))  # of 2^5 - 1 ways
    assert {way[:-1] for way in followed[1:]} == contacts
    assert (len(followed) > 1 + len(contacts)) == heavy


def judged(objects, name, before, after):
    """What is said of the fall of an object from one pose to another among others that stand there."""
    scene = Scene.of(Task("fall", tuple(objects)))
    state = State({o.name: o.pose.matrix for o in objects}, np.array(load_robot("panda").home))
    state.poses[name], found = before.matrix, []
    check_fall(scene, state, Fall(name, after), DEFAULT, lambda kind, *told, **more: found.append(told[0]))
    return " ".join(found)


def book_at(tilt, x=0.0, z=0.0):
    """A book 160 mm high and 20 mm thick, tilted by an angle about its lower edge at x [rad]."""
    return Pose.from_rpy((x, 0.0, z), (0.0, tilt, 0.0)) @ Pose((-0.01, 0.0, 0.08))


@pytest.mark.parametrize(
    ("width", "height", "mass", "friction", "tips"),
    [
        (0.012, 0.06, 0.1, 0.5, True),
        (0.012, 0.09, 1.0, 0.5, True),
        (0.03, 0.09, 0.1, 0.5, True),
        (0.03, 0.06, 0.1, 0.5, False),
        (0.012, 0.03, 0.1, 0.5, False),
        (0.06, 0.06, 0.1, 0.5, False),
        (0.012, 0.09, 0.1, 1.0, False),  # the book does not slip down along it, and holds it to the table
    ],
)
def test_what_a_turning_fall_strikes_near_its_top_tips_over_as_it_does_in_a_simulator(
    width, height, mass, friction, tips
):
    tilt = np.pi / 2 - np.arctan2(height, 0.12 - width / 2)
    book = Object("book", Box((0.02, 0.12, 0.16)), book_at(tilt), mass=1.0, friction=friction)
    struck = Object("domino", Box((width, 0.06, height)), Pose((0.12, 0.0, height / 2)), mass=mass, friction=friction)
    found = judged([book, struck], "book", book_at(max(0.3, tilt - 0.9)), book_at(tilt))
    assert ("domino tips over when book falls" in found) == tips, found


@pytest.mark.parametrize(("thick", "tips"), [(0.004, True), (0.012, False)])
def test_what_a_turning_fall_comes_down_on_tips_over_where_it_is_narrow(thick, tips):
    flat = book_at(np.pi / 2, 0.03, 0.06)
    book = Object("book", Box((0.02, 0.12, 0.16)), flat, mass=1.0)
    block = Object("block", Box((0.06, 0.12, 0.06)), Pose((0.03, 0.0, 0.03)))
    domino = Object("domino", Box((thick, 0.06, 0.06)), Pose((0.15, 0.0, 0.03)), mass=0.05)
    found = judged([book, block, domino], "book", book_at(0.8, 0.03, 0.06), flat)
    assert ("domino tips over when book falls" in found) == tips, found
    assert "block tips over" not in found


@pytest.mark.parametrize(("over", "hits"), [(0.002, True), (0.0005, False)])
def test_what_falls_grazes_nothing_that_it_merely_passes(over, hits):
    red = Object("red", Box((0.04, 0.04, 0.04)), Pose((0.1, 0.0, 0.02)))
    shelf = Object("shelf", Box((0.04, 0.04, 0.02)), Pose((0.14 - over, 0.0, 0.09)))
    found = judged([red, shelf], "red", Pose((0.1, 0.0, 0.15)), red.pose)
    assert ("falls 2.0 mm into shelf" in found) == hits


@pytest.mark.parametrize(
    ("thick", "high", "over", "tips"), [(0.01, 0.06, 0.0015, True), (0.02, 0.03, 0.001, True), (0.05, 0.03, 0.0, False)]
)
def test_a_flank_that_a_fall_slides_past_is_struck_aside_and_bears_no_weight(tmp_path, thick, high, over, tips):
    """What widens upwards, by sides of 69 degrees, falls beside a domino; PyBullet and MuJoCo agree."""
    corners = [(x * half, y, z) for half, z in ((0.02, -0.04), (0.05, 0.04)) for x in (-1, 1) for y in (-0.05, 0.05)]
    file, hull = tmp_path / "wedge.obj", convex_hull(np.array(corners))
    lines = [*(f"v {x} {y} {z}" for x, y, z in hull.vertices), *(f"f {a} {b} {c}" for a, b, c in hull.faces + 1)]
    file.write_text("\n".join(lines))
    wedge = Object("wedge", Mesh(file), Pose((0.0, 0.0, 0.04)), mass=1.0)
    at = 0.02 + 0.03 * high / 0.08 + thick / 2 - over
    domino = Object("domino", Box((thick, 0.06, high)), Pose((at, 0.0, high / 2)), mass=0.05)
    found = judged([wedge, domino], "wedge", Pose((0.0, 0.0, 0.14)), wedge.pose)
    assert ("domino tips over when wedge falls" in found) == tips, found


def on_foot(path, foot, plate, aside, *ledge):
    """A plate, 60 mm long, on a foot as long that is so far aside; of both their width and height is given [m].

    Around the foot may be a ledge of such a width that begins so high.
    """
    lines, (low, high) = list[str](), (foot[1], foot[1] + plate[1])
    wide_from_to = [(foot[0], aside, 0.0, low), (plate[0], 0.0, low, high)]
    for number, (wide, middle, lower, upper) in enumerate([*wide_from_to, *((w, aside, z, low) for w, z in ledge)]):
        hull = convex_hull((CUBE - (0.5, 0.5, 0.0)) * (wide, 0.06, upper - lower) + (middle, 0.0, lower))
        faces = hull.faces + 1 + sum(line.startswith("v") for line in lines)
        lines += [f"o part{number}", *(f"v {x} {y} {z}" for x, y, z in hull.vertices)]
        lines += [f"f {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(lines))
    return Object("plate", Mesh(path), Pose((0.0, 0.0, 0.0)), mass=0.2)


def test_a_rim_catches_also_what_stands_across_a_gap(tmp_path):
    """What is 2 mm above the table counts as standing on it: what catches the rim is that much lower."""
    body = on_foot(tmp_path / "plate.obj", (0.04, 0.01), (0.14, 0.015), 0.016, (0.05, 0.002))
    hull, stood = Solid.of("plate", parts(body.shape)).hull.part.vertices, body.pose.matrix
    *_, (tilted, _) = islice(rolls(hull, stood, np.array([1.0, 0.0])), 7)
    assert judged([body], "plate", Pose.from_matrix(tilted), body.pose) == ""


@pytest.mark.parametrize(
    ("foot", "plate", "aside", "tips"),
    [
        ((0.04, 0.01), (0.14, 0.015), 0.016, False),  # its rim comes down before it is in balance on the foot's edge
        ((0.05, 0.01), (0.11, 0.015), 0.02, False),
        ((0.05, 0.02), (0.11, 0.03), 0.02, True),  # and here after that: it comes to rest on its rim
        ((0.05, 0.03), (0.05, 0.10), 0.02, True),  # it has none
    ],
)
def test_what_comes_down_on_a_narrow_foot_tips_on_unless_its_rim_catches_it(tmp_path, foot, plate, aside, tips):
    body = on_foot(tmp_path / "plate.obj", foot, plate, aside)
    hull, stood = Solid.of("plate", parts(body.shape)).hull.part.vertices, body.pose.matrix
    *_, (tilted, _) = islice(rolls(hull, stood, np.array([1.0, 0.0])), 7)
    let_go = Pose.from_matrix(tilted)
    assert judged([body], "plate", let_go, body.pose) == (
        "plate tips on over the edge of table as it comes down on it" if tips else ""
    )
    assert tips_on(workspace_of(body).world.geometries["plate"], let_go, body.pose) == tips  # as the planner sees it
    end = let_fall([body], {"plate": let_go}, table=Table())["plate"]
    assert (tilt(end.matrix, stood) > 0.1) == tips
