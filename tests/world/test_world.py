"""Collision: against python-fcl, among hulls and hollows, with margins, and through shared structures."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from benchmarks.collision import FclReference, _configurations, _scene
from tamp.task import Box, Mesh
from tamp.world.geometry.object_geometry import geometry_of, load_geometry
from tamp.world.kinematics.inverse import inverse
from tamp.world.scene import Scene
from tamp.world.world import World

OCRTOC = Path(__file__).parents[2].parent / "shared" / "ocrtoc" / "2021" / "models"
DOWN = np.diag([1.0, -1.0, -1.0, 1.0])


def at(x, y, z):
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def tool_at(x, y, z):
    T = DOWN.copy()
    T[:3, 3] = x, y, z
    return T


@pytest.fixture(scope="module")
def box_world(panda):
    return World(panda, {name: load_geometry(Box((0.05, 0.05, 0.08))) for name in ("a", "b", "c")})


def reach(panda, T):
    return next(inverse(panda, T, np.random.default_rng(0)))


@pytest.mark.parametrize("count", [10, 30])
def test_python_fcl_finds_no_missed_penetration_and_no_false_hit(panda, count):
    scene, world = _scene(panda, count)
    checker = world.checker(scene, margin=0.002)
    reference = FclReference(panda, world, scene)
    free = 0
    for q in _configurations(panda, np.random.default_rng(count), 400):
        if checker.free(q):
            free += 1
            assert reference.depth(q) < 0.001
        else:
            assert reference.distance(q) <= 0.002 + 1e-5
    assert 100 < free < 390


def test_home_is_free_and_a_hand_in_a_box_is_not(panda, box_world):
    scene = Scene({"a": at(0.1, 0, 0.04)}, opening=0.08)
    checker = box_world.checker(scene)
    assert checker.free(panda.home)
    assert checker.contact(panda.home) is None
    q = reach(panda, tool_at(0.1, 0.05, 0.05))
    contact = checker.contact(q)
    assert not checker.free(q)
    assert contact.b == "a"
    assert contact.a in {"panda_hand", "panda_leftfinger", "panda_rightfinger"}
    assert contact.distance < 0
    assert "a" in str(contact)


def test_fingers_straddle_a_box_where_touching_it_is_allowed(panda, box_world):
    q = reach(panda, tool_at(0.1, 0, 0.05))
    snug = Scene({"a": at(0.1, 0, 0.04)}, opening=0.052)
    assert not box_world.checker(snug, margin=0.005).free(q)
    assert box_world.checker(snug, margin=0.005, touch={"a": 0.0}).free(q)
    assert box_world.checker(snug, margin=0.005).contact(q).b == "a"


def test_a_held_object_collides_and_its_own_margin_lets_it_touch(panda, box_world):
    q = reach(panda, tool_at(0.1, 0, 0.041))
    holding = Scene({"b": at(-0.1, 0.3, 0.04)}, opening=0.05).attached("a", DOWN, 0.05)
    assert box_world.checker(holding).contact(q).a == "table"
    assert box_world.checker(holding, held_margin=-0.003).free(q)
    deep = reach(panda, tool_at(0.1, 0, 0.03))
    assert not box_world.checker(holding, held_margin=-0.003).free(deep)
    beside = holding.moved("b", at(0.14, 0, 0.04))
    contact = box_world.checker(beside, held_margin=-0.003).contact(reach(panda, tool_at(0.1, 0, 0.06)))
    assert {contact.a, contact.b} == {"a", "b"}


def test_checkers_used_in_turns_do_not_disturb_each_other(panda, box_world):
    q = reach(panda, tool_at(0.1, 0, 0.05))
    near = box_world.checker(Scene({"a": at(0.1, 0, 0.04)}, opening=0.0))
    far = box_world.checker(Scene({"a": at(-0.1, 0.4, 0.04), "b": at(0.2, -0.4, 0.04)}, opening=0.0))
    strict = box_world.checker(Scene({"a": at(0.1, 0.3, 0.04)}, opening=0.0), margin=0.25)
    for _ in range(3):
        assert not near.free(q)
        assert far.free(q)
        assert not strict.free(q)


def test_an_edge_is_free_where_all_its_states_are(panda, box_world):
    checker = box_world.checker(Scene({"a": at(0.1, 0, 0.04)}, opening=0.08))
    rng = np.random.default_rng(0)
    outcomes = set()
    for _ in range(60):
        q0, q1 = panda.home + rng.uniform(-0.7, 0.7, (2, 7))
        steps = max(1, int(np.ceil(np.linalg.norm(q1 - q0) / 0.05)))
        states = [q0 + k / steps * (q1 - q0) for k in range(steps + 1)]
        free = all(checker.free(q) for q in states)
        assert checker.edge_free(q0, q1) == free
        assert checker.path_free(np.array([q0, q1])) == free
        assert (checker.first_contact(np.array([q0, q1])) is None) == free
        outcomes.add(free)
    assert outcomes == {True, False}


def test_distance_is_what_moving_closer_takes_away(panda, box_world):
    q = reach(panda, tool_at(0.1, 0, 0.3))
    low = reach(panda, tool_at(0.1, 0, 0.1))
    scene = Scene({"a": at(0.1, 0, 0.04)}, opening=0.08)
    checker = box_world.checker(scene)
    assert checker.distance(q) > checker.distance(low)
    nearest = checker.nearest(low)
    assert nearest.b == "a"
    margin = nearest.distance
    assert box_world.checker(scene, margin=margin - 1e-4).free(low) or nearest.distance < 0.002
    assert not box_world.checker(scene, margin=margin + 1e-4).free(low)


def test_fingers_reach_into_a_hollow(panda):
    walls = []
    for size, center in [
        ((0.2, 0.2, 0.01), (0, 0, 0.005)),
        ((0.01, 0.2, 0.08), (-0.095, 0, 0.05)),
        ((0.01, 0.2, 0.08), (0.095, 0, 0.05)),
        ((0.2, 0.01, 0.08), (0, -0.095, 0.05)),
        ((0.2, 0.01, 0.08), (0, 0.095, 0.05)),
    ]:
        (part,) = load_geometry(Box(size)).parts
        walls.append(type(part)(part.vertices + np.array(center), part.faces))
    world = World(panda, {"tray": geometry_of(walls), "cube": load_geometry(Box((0.04, 0.04, 0.04)))})
    scene = Scene({"tray": at(0.1, 0, 0), "cube": at(-0.2, 0.4, 0.02)}, opening=0.05)
    inside, wall = reach(panda, tool_at(0.1, 0, 0.06)), reach(panda, tool_at(0.19, 0, 0.06))
    assert world.checker(scene).free(inside)
    assert world.checker(scene).contact(wall).b == "tray"
    assert world.hand_contact(tool_at(0.1, 0, 0.06), 0.05, scene) is None
    assert world.hand_contact(tool_at(0.19, 0, 0.06), 0.05, scene) == "tray"
    assert not world.overlap("cube", at(0.1, 0, 0.031), "tray", at(0.1, 0, 0))
    assert world.overlap("cube", at(0.18, 0, 0.031), "tray", at(0.1, 0, 0))


def test_the_hand_alone_sees_what_the_arm_with_its_hand_sees(panda, box_world):
    rng = np.random.default_rng(1)
    scene = Scene({"a": at(0.1, 0, 0.04), "b": at(0.1, 0.1, 0.04), "c": at(0.0, 0.0, 0.04)}, opening=0.06)
    checker = box_world.checker(scene)
    hand = {"panda_hand", "panda_leftfinger", "panda_rightfinger"}
    seen = set()
    for _ in range(60):
        T = tool_at(*rng.uniform([-0.05, -0.1, 0.0], [0.2, 0.2, 0.2]))
        blocked = box_world.hand_contact(T, 0.06, scene)
        for q in inverse(panda, T, rng, count=1):
            contact = checker.contact(q)
            if blocked is None and contact is not None:
                assert contact.a not in hand or contact.b.startswith("panda")
            if blocked is not None:
                assert contact is not None
        seen.add(blocked)
    assert {None, "a", "b", "c"} <= seen


def test_the_hand_ignores_what_it_is_told_to(box_world):
    T = tool_at(0.1, 0, 0.05)
    scene = Scene({"a": at(0.1, 0, 0.04)})
    assert box_world.hand_contact(T, 0.0, scene) == "a"
    assert box_world.hand_contact(T, 0.0, scene, ignore=("a",)) is None
    assert box_world.hand_contact(tool_at(0.1, 0, -0.01), 0.0, scene, ignore=("a",)) == "table"
    assert box_world.hand_contact(tool_at(0.1, 0, -0.01), 0.0, scene, ignore=("a", "table")) is None
    holding = Scene({"b": at(0.1, 0.04, 0.04)}).attached("a", DOWN, 0.05)
    assert box_world.hand_contact(tool_at(0.1, 0, 0.2), 0.05, holding) is None
    assert box_world.hand_contact(tool_at(0.1, 0, 0.06), 0.05, holding) == "b"


def test_objects_meet_the_table_and_the_base(box_world):
    assert not box_world.overlap("a", at(0, 0, 0.04), "table")
    assert box_world.overlap("a", at(0, 0, 0.03), "table")
    assert box_world.separation("a", at(0, 0, 0.1), "table") == pytest.approx(0.06, abs=1e-6)
    assert box_world.overlap("a", at(-0.42, 0, 0.05), "robot")
    assert not box_world.overlap("a", at(0.2, 0, 0.05), "robot")
    with pytest.raises(KeyError, match="no body 'd'"):
        box_world.overlap("a", np.eye(4), "d", np.eye(4))


@given(seed=st.integers(0, 10_000), tolerance=st.sampled_from([0.003, 0.0, -0.01, -0.05]))
@settings(max_examples=30, deadline=None)
def test_many_poses_are_answered_as_each_by_itself(panda, seed, tolerance):
    rng, bowl = np.random.default_rng(seed), [Box((0.2, 0.02, 0.1)), Box((0.02, 0.2, 0.1))]
    parts = [part for shape in bowl for part in load_geometry(shape).parts]
    world = World(panda, {"cross": geometry_of(parts), "stick": load_geometry(Box((0.02, 0.02, 0.2)))})
    T = np.tile(np.eye(4), (40, 1, 1))
    T[:, :3, :3] = Rotation.random(40, random_state=seed).as_matrix()
    T[:, :3, 3] = rng.uniform(-0.3, 0.3, (40, 3))
    for a, b, T_b in (("stick", "cross", at(0.05, 0.0, 0.1)), ("cross", "stick", T[0]), ("stick", "table", None)):
        alone = [k for k in range(40) if world.overlap(a, T[k], b, T_b, tolerance)]
        assert [*world.overlapping(a, T, b, T_b, tolerance)] == alone
        assert world.overlaps(a, T, b, T_b, tolerance) == bool(alone)


def test_a_model_of_many_parts_is_checked_by_its_parts(panda):
    path = OCRTOC / "bowl" / "collision.obj"
    if not path.is_file():
        pytest.skip("the OCRTOC models are not beside this checkout")
    bowl = load_geometry(Mesh(path))
    world = World(panda, {"bowl": bowl, "berry": load_geometry(Box((0.03, 0.03, 0.03)))})
    T = at(0.1, 0, -bowl.lower[2])
    centre = (bowl.lower + bowl.upper) / 2 + T[:3, 3]
    inside = at(centre[0], centre[1], centre[2] + 0.01)
    assert not world.overlap("berry", inside, "bowl", T)
    assert world.separation("berry", inside, "bowl", T) > 0.005
    assert world.hand_contact(tool_at(*(inside[:3, 3] + [0, 0, 0.02])), 0.03, Scene({"bowl": T})) is None
