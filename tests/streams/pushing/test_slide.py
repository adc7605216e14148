from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
import trimesh

from tamp.streams.affordances.slide_path import directions, shifted, tips_above, ways, ways_to
from tamp.streams.hand.hand_boxes import hand_boxes
from tamp.streams.motion.handling_contacts import approach_contact
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.pushing.grasp_after_push import sample_exposed_grasp
from tamp.streams.pushing.hand_contact import barred, hands_at
from tamp.streams.pushing.push_motion import learn_refused_push, push_hits, pushes
from tamp.streams.pushing.slide import _one_push, plan_sliding, plan_sliding_to, test_cfree_slide
from tamp.streams.values import Placement
from tamp.task import Box, Mesh, Object, Pose
from tamp.world.scene import Scene
from tamp.world.transforms import moved
from tests.streams.tables import CRATE, ToldContext, corners, workspace_of

test_cfree_slide.__test__ = False

BOX = Object("box", Box((0.17, 0.11, 0.045)), Pose.from_rpy((-0.05, -0.35, 0.0225), (0.0, 0.0, 0.3)), friction=0.8)
PEG = Object("peg", Box((0.02, 0.02, 0.02)), Pose((0.1, 0.3, 0.01)))


@pytest.fixture(scope="module")
def workspace():
    return workspace_of(BOX, PEG)


@pytest.fixture(scope="module")
def offer(workspace):
    return next(plan_sliding(ToldContext(workspace), "box", workspace.start["box"]))


def beside_the_end(start, end):
    """A place near the end of a straight way and to one side of it: ways slanted to the other side keep clear of it."""
    shift = np.subtract(end.pose.xyz, start.pose.xyz)[:2]
    x, y = start.pose.xyz[:2] + 0.9 * shift + 0.08 * np.array([-shift[1], shift[0]]) / np.linalg.norm(shift)
    return Placement(Pose((float(x), float(y), 0.01)), ("table",))


def test_the_hand_takes_the_object_straight_to_where_it_is_gripped(workspace, offer):
    end, before, after, slide = offer
    robot = workspace.world.robot
    for q, placement in ((slide.push[0], workspace.start["box"]), (slide.push[-1], end)):
        T = robot.forward(q) @ slide.T_tool_object.matrix
        np.testing.assert_allclose(T, placement.pose.matrix, atol=1e-4)
    path = np.array([robot.forward(q)[:3, 3] for q in slide.push])
    ahead = (path[-1] - path[0]) / np.linalg.norm(path[-1] - path[0])
    beside = (path - path[0]) - np.outer((path - path[0]) @ ahead, ahead)
    assert np.abs(beside).max() < 1e-3
    assert before.q == tuple(slide.approach[0]) and after.q == tuple(slide.retreat[-1])


def test_a_slide_to_a_place_straight_ahead_ends_there_as_the_object_lies(workspace):
    start = workspace.start["box"]
    ahead = directions(workspace, "box", start)[0].ahead
    end = shifted(start, 0.15 * ahead)
    for before, after, slide in plan_sliding_to(ToldContext(workspace), "box", start, end):
        T = workspace.world.robot.forward(slide.push[-1]) @ slide.T_tool_object.matrix
        np.testing.assert_allclose(T, end.pose.matrix, atol=1e-4)
        assert before.q == tuple(slide.approach[0]) and after.q == tuple(slide.retreat[-1])
        break
    else:
        pytest.fail("no slide")


def test_no_straight_way_leads_aside_nor_to_where_an_object_is_turned_or_raised(workspace):
    start = workspace.start["box"]
    direction = directions(workspace, "box", start)[0]
    aside = direction.behind[::-1] * (1.0, -1.0)
    (x, y, z), yaw = shifted(start, 0.15 * direction.ahead).pose.xyz, 0.3
    assert ways_to(workspace, "box", start, shifted(start, 0.15 * direction.ahead))
    assert not ways_to(workspace, "box", start, start)
    assert not ways_to(workspace, "box", start, shifted(start, 0.15 * direction.ahead + 0.08 * aside))
    assert not ways_to(workspace, "box", start, Placement(Pose((x, y, z + 0.01), start.pose.quat), ("table",)))
    turned = Pose.from_rpy((x, y, z), (0.0, 0.0, yaw + 0.05))
    assert not ways_to(workspace, "box", start, Placement(turned, ("table",)))
    assert not ways_to(workspace, "peg", workspace.start["peg"], shifted(workspace.start["peg"], 0.1 * direction.ahead))


def test_the_hand_comes_down_clear_of_the_object_and_then_touches_it(workspace, offer):
    slide, start = offer[-1], workspace.start["box"].pose
    assert approach_contact(workspace, "box", start, slide.opening, slide.approach, {}) is None
    farther = slide.push[:3]  # the fingers go into an object that does not give way
    assert approach_contact(workspace, "box", start, slide.opening, farther, {}) is not None


def test_where_it_hangs_over_the_edge_it_can_be_gripped(workspace, offer):
    context = ToldContext(workspace)
    grasps = islice(sample_exposed_grasp(context, "box", offer[0]), 10)
    assert any(next(inverse_kinematics(context, "box", offer[0], grasp), None) is not None for grasp in grasps)


def test_what_stands_in_the_way_of_the_object_is_hit_and_what_stands_elsewhere_is_not(workspace, offer):
    end, _, _, slide = offer
    x, y = (np.array(workspace.start["box"].pose.xyz[:2]) + end.pose.xyz[:2]) / 2
    in_the_way = Placement(Pose((x, y, 0.01)), ("table",))
    assert push_hits(workspace, slide, {"peg": in_the_way}) is not None
    assert push_hits(workspace, slide, {"peg": workspace.start["peg"]}) is None
    context = ToldContext(workspace)
    assert not test_cfree_slide(context, "box", slide, "peg", in_the_way)
    assert context.reasons and "peg" in context.reasons[0]
    assert test_cfree_slide(context, "box", slide, "peg", workspace.start["peg"])


def test_slides_that_are_free_of_what_stands_there_come_first(workspace, offer):
    around = (("AtPose", "peg", beside_the_end(workspace.start["box"], offer[0])),)
    context = ToldContext(workspace, bound=around)
    offers = list(plan_sliding(context, "box", workspace.start["box"]))
    free = [push_hits(workspace, slide, {"peg": around[0][2]}) is None for *_, slide in offers]
    assert free == sorted(free, reverse=True) and any(free) and not all(free)


def test_a_way_is_barred_by_what_stands_in_it_or_where_the_hand_would_be(workspace, offer):
    end, _, _, slide = offer
    start = workspace.start["box"]
    way = next(way for way in ways(workspace, "box", start) if way.end == end)
    x, y = (np.array(start.pose.xyz[:2]) + end.pose.xyz[:2]) / 2
    hand = workspace.world.robot.forward(slide.push[-1])[:3, 3]
    elsewhere = workspace.start["peg"]
    assert not barred(workspace, "box", start, way, {"peg": elsewhere})
    for at, height in (((x, y), 0.01), (hand[:2], hand[2])):  # in the air, only the hand comes there
        peg = Placement(Pose((float(at[0]), float(at[1]), float(height))), ("table",))
        assert barred(workspace, "box", start, way, {"peg": peg})
        assert push_hits(workspace, slide, {"peg": peg}) is not None


def test_barred_ways_come_after_all_others_though_they_are_looked_at_last(workspace, offer):
    start = workspace.start["box"]
    peg = beside_the_end(start, offer[0])
    context = ToldContext(workspace, bound=(("AtPose", "peg", peg),))
    ended = [end for end, *_ in plan_sliding(context, "box", start)]
    bars = {way.end: barred(workspace, "box", start, way, {"peg": peg}) for way in ways(workspace, "box", start)}
    told = [bars[end] for end in ended]
    assert told == sorted(told) and any(told) and not all(told)


def test_a_slim_hand_pushes_with_the_back_of_one_finger_and_is_narrower(workspace, offer):
    start = workspace.start["box"]
    way = next(way for way in ways(workspace, "box", start) if way.end == offer[0])
    across = np.array([-way.behind[1], way.behind[0]])
    closing = np.array(workspace.world.robot.spec.gripper.axis)
    for slim, along in ((False, across), (True, way.behind)):
        for T, opening in hands_at(workspace, "box", start, way, slim):
            assert abs((T[:3, :3] @ closing)[:2] @ along) == pytest.approx(1.0)
            assert (opening == 0.0) == slim
    assert next(pushes(ToldContext(workspace), "box", start, way, workspace.hand.push_gap, slim=True)).end == way.end


def test_where_only_a_slim_hand_has_room_behind_it_that_pushes(workspace, monkeypatch):
    def slim_alone(workspace, obj, placement, way, slim):
        return hands_at(workspace, obj, placement, way, slim) if slim else iter(())

    monkeypatch.setattr("tamp.streams.pushing.push_motion.hands_at", slim_alone)
    monkeypatch.setattr("tamp.streams.pushing.slide.hands_at", slim_alone)
    start = workspace.start["box"]
    (*_, slide) = next(plan_sliding(ToldContext(workspace, seed=1), "box", start))
    assert slide.opening == 0.0
    by_detour = _one_push(ToldContext(workspace, seed=1), "box", start, ways(workspace, "box", start)[0])
    assert by_detour.opening == 0.0


def test_where_neighbours_leave_little_room_the_hand_keeps_close_to_the_object(workspace, offer):
    end, _, _, slide = offer
    T = workspace.world.robot.forward(slide.push[0])
    back = np.array(workspace.start["box"].pose.xyz) - end.pose.xyz
    back /= np.linalg.norm(back)
    finger = T[:3, 3] + T[:3, :3] @ np.array(workspace.world.robot.spec.gripper.axis) * slide.opening / 2
    places = [finger + distance * back for distance in np.arange(0.03, 0.1, 0.002)]
    behind = [Placement(Pose((float(x), float(y), 0.01)), ("table",)) for x, y, _ in places]
    met = [place for place in behind if push_hits(workspace, slide, {"peg": place}) is not None]
    context = ToldContext(workspace, bound=(("AtPose", "peg", met[-1]),))
    close = next(s for ended, *_, s in plan_sliding(context, "box", workspace.start["box"]) if ended == end)
    assert push_hits(workspace, close, {"peg": met[-1]}) is None


@pytest.mark.parametrize("angle", [0.0, 2.75, np.pi])
def test_every_hand_that_pushes_touches_what_it_pushes_from_outside(angle):
    """Also what is hollow, and leans: a hand in its hollow would push nothing."""
    turned = Pose.from_rpy((0.0, 0.0, 0.0), (angle, 0.0, 0.3))
    crate = Object("crate", CRATE.shape, turned)
    lowest = corners(workspace_of(crate), "crate", turned)[:, 2].min()
    pose = Pose((0.05, -0.2, -float(lowest)), turned.quat)
    workspace = workspace_of(replace(crate, pose=pose))
    start, hands = workspace.start["crate"], 0
    for direction in directions(workspace, "crate", start):
        way = direction.way(start, np.zeros(2), 0.1, 0.0)
        for slim in (False, True):
            for T, opening in hands_at(workspace, "crate", start, way, slim):
                hands += 1
                nearer = moved(T, -0.001 * np.append(way.behind, 0.0))
                scene = Scene({"crate": pose.matrix})
                assert workspace.world.hand_contact(T, opening, scene, margin=0.0) is None
                assert workspace.world.hand_contact(nearer, opening, scene, margin=0.0) == "crate"
                for away in np.arange(0.01, 0.1, 0.01):
                    farther = moved(T, away * np.append(way.behind, 0.0))
                    assert workspace.world.hand_contact(farther, opening, scene, margin=0.0) is None
    assert hands


def test_all_four_sides_of_a_wedge_are_pushed_though_one_leans_and_one_is_low(tmp_path):
    """The palm cannot be above its top where the low side is pushed, and the side that leans is met farther in."""
    profile = np.array([(-0.08, 0.0), (0.08, 0.0), (0.05, 0.1), (-0.08, 0.03)])  # x and z
    corners = np.array([(x, y, z) for y in (-0.08, 0.08) for x, z in profile])
    path = tmp_path / "wedge.stl"
    trimesh.convex.convex_hull(corners).export(path)
    workspace = workspace_of(Object("wedge", Mesh(path), Pose((0.1, -0.1, 0.0))))
    start, pushed = workspace.start["wedge"], list[np.ndarray]()
    for direction in directions(workspace, "wedge", start):
        way = direction.way(start, np.zeros(2), 0.1, 0.0)
        pushed += [direction.behind for _ in hands_at(workspace, "wedge", start, way, False)]
    for side in np.vstack([np.eye(2), -np.eye(2)]):
        assert any(behind @ side > 0.99 for behind in pushed), f"no hand pushes the side {side}"


def test_fingers_that_would_touch_it_on_one_side_only_do_not_push(tmp_path):
    """From above its side is as wide as its foot, which is lower than fingers reach; above that it is a narrow wall."""
    foot, wall = Box((0.16, 0.16, 0.006)), Box((0.02, 0.02, 0.07))
    parts = [trimesh.creation.box(foot.size), trimesh.creation.box(wall.size)]
    parts[0].apply_translation((0.0, 0.0, 0.003))
    parts[1].apply_translation((0.07, 0.07, 0.041))
    path = tmp_path / "foot.obj"
    path.write_text(
        "".join(
            f"o part{k}\n"
            + "".join("v {:.6f} {:.6f} {:.6f}\n".format(*v) for v in part.vertices)
            + "".join("f {} {} {}\n".format(*(f + 1 + 8 * k)) for f in part.faces)
            for k, part in enumerate(parts)
        )
    )
    workspace = workspace_of(Object("foot", Mesh(path), Pose((-0.05, -0.3, 0.0))))
    start = workspace.start["foot"]
    for direction in directions(workspace, "foot", start):
        way = direction.way(start, np.zeros(2), 0.1, 1.0)
        for slim in (False, True):
            for tool, opening in hands_at(workspace, "foot", start, way, slim):
                touched = workspace.world.free_hand(Scene({"foot": start.pose.matrix}), 0.002)
                assert touched.hit(tool, opening)
                beside = np.array([-direction.ahead[1], direction.ahead[0]])
                middle = (start.pose.matrix[:2, 3] + (0.07, 0.07) - way.touch) @ beside
                assert abs(middle) < 0.02  # only through the wall itself, which they embrace


@pytest.mark.parametrize(("friction", "able"), [(0.3, True), (0.5, True), (0.8, True), (0.5, False)])
def test_what_is_wide_at_its_foot_is_pushed_low_though_it_would_tip_if_pushed_at_its_top(tmp_path, friction, able):
    """Upright fingers touch it where it reaches farthest: at the foot of a lampshade, and at the rim of a bucket."""
    foot, top = (0.06, 0.04) if able else (0.04, 0.06)
    corners = [(x * w, y * w, z) for w, z in ((foot, 0.0), (top, 0.12)) for x in (-1, 1) for y in (-1, 1)]
    path = tmp_path / "shade.stl"
    trimesh.convex.convex_hull(np.array(corners)).export(path)
    workspace = workspace_of(Object("shade", Mesh(path), Pose((0.1, -0.1, 0.0)), friction=friction))
    start = workspace.start["shade"]
    found = ways_to(workspace, "shade", start, shifted(start, np.array([0.0, 0.1])))
    hands = [(way, *hand) for way in found for hand in hands_at(workspace, "shade", start, way, False)]
    assert bool(hands) == able
    for way, tool, opening in hands:
        tip = tool[2, 3] - hand_boxes(workspace.world.robot).tip(opening)
        assert tip < tips_above(workspace, "shade", start, np.append(way.shift, 0.0) / 0.1)


def test_what_is_pushed_over_an_edge_is_pushed_low_enough_not_to_tip_about_that_edge():
    """On the way it is shorter and shorter what carries it before its centre of mass."""
    workspace = workspace_of(Object("tea", Box((0.15, 0.11, 0.085)), Pose((0.1, -0.1, 0.0425)), friction=0.5))
    start, found = workspace.start["tea"], list[float]()
    table, corners_of = workspace.task.table, np.array([(x, y) for x in (-0.075, 0.075) for y in (-0.055, 0.055)])
    for way in ways(workspace, "tea", start):
        ahead = way.shift / np.linalg.norm(way.shift)
        lower, upper = (np.array(table.center) + side * np.array(table.size) / 2 for side in (-1, 1))
        carried = np.clip(corners_of + way.end.pose.xyz[:2], lower, upper)  # of the box, which is not turned
        lever = ((carried - way.end.pose.xyz[:2]) @ ahead).max()
        for tool, opening in hands_at(workspace, "tea", start, way, False):
            tip = tool[2, 3] - hand_boxes(workspace.world.robot).tip(opening)
            assert 0.5 * tip < lever
            found.append(tip)
    assert found


@pytest.mark.parametrize("degrees", [0.0, 10.0, -20.0])
def test_what_is_pushed_aslant_tips_about_the_edge_that_the_way_crosses_and_not_about_its_farthest_corner(degrees):
    workspace = workspace_of(Object("rail", Box((0.17, 0.03, 0.03)), Pose((0.1, -0.1, 0.015)), friction=0.5))
    ahead = np.array([np.sin(np.radians(degrees)), np.cos(np.radians(degrees)), 0.0])
    found = tips_above(workspace, "rail", workspace.start["rail"], ahead)
    assert 0.5 * found <= 0.015 / ahead[1] < 0.65 * found


def test_a_push_that_the_checker_refuses_is_not_offered_again():
    workspace = workspace_of(BOX, PEG)
    offered = [slide for *_, slide in islice(plan_sliding(ToldContext(workspace), "box", workspace.start["box"]), 3)]
    learn_refused_push(workspace, offered[0])
    again = [slide for *_, slide in islice(plan_sliding(ToldContext(workspace), "box", workspace.start["box"]), 3)]
    assert offered[0] not in again and offered[-1] in again


def test_a_slim_hand_whose_finger_gets_narrower_to_its_tip_pushes_what_is_tall_with_what_is_above_it():
    """So it would tip it about the edge of the table, where a hand that lies against it with both fingers does not."""
    workspace = workspace_of(Object("tea", Box((0.15, 0.11, 0.06)), Pose((0.1, -0.1, 0.03)), friction=0.5))
    start = workspace.start["tea"]
    (way, *_) = ways(workspace, "tea", start)
    assert [*hands_at(workspace, "tea", start, way, False)] and not [*hands_at(workspace, "tea", start, way, True)]
    short = replace(way, end=shifted(start, 0.05 * way.shift / np.linalg.norm(way.shift)))
    assert [*hands_at(workspace, "tea", start, short, True)], "on the table it may"
