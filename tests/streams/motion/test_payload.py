from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamp.domains.timing import Timing
from tamp.streams.motion import lift
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.motion.payload import Carried, load_aware, push_too_heavy
from tamp.streams.pushing.slide import plan_sliding
from tamp.streams.values import Grasp
from tamp.task import Attachment, Box, Pose
from tamp.world.scene import Scene
from tests.streams.pushing.test_slide import BOX
from tests.streams.tables import RED, ToldContext, panda, workspace_of

FROM_ABOVE = Grasp(Pose.from_rpy((0.0, 0.0, 0.02), (np.pi, 0.0, 0.0)), 0.05)
T_TOOL_RED = FROM_ABOVE.T_object_tool.inverse().matrix


def red(mass, x=RED.pose.xyz[0]):
    _, y, z = RED.pose.xyz
    return workspace_of(replace(RED, mass=mass, friction=2.0, pose=Pose((x, y, z))))


def taken(workspace):
    context = ToldContext(workspace)
    return list(inverse_kinematics(context, "red", workspace.start["red"], FROM_ABOVE)), context.reasons


def test_only_what_some_configuration_does_not_bear_is_asked_about():
    assert Carried(red(1.0), "red", T_TOOL_RED, 0.05).light
    assert not Carried(red(20.0), "red", T_TOOL_RED, 0.05).light


def test_what_the_arm_does_not_bear_is_not_taken_and_the_joint_is_named():
    assert taken(red(5.0))[0]
    found, reasons = taken(red(40.0))
    assert not found
    assert any("the weight of red asks" in reason and "of panda_joint" in reason for reason in reasons)


def test_where_it_does_not_bear_it_no_way_off_is_looked_for(monkeypatch):
    asked = []
    monkeypatch.setattr(lift, "_path", lambda workspace, reach, way: asked.append(way) or (None, "no way"))
    assert not taken(red(5.0))[0] and asked
    asked.clear()
    assert not taken(red(100.0))[0] and not asked


def test_on_its_way_the_arm_does_not_stretch_out_with_what_is_heavy():
    workspace = red(12.0)
    near, far = np.array(panda().home), np.array([0.0, 1.2, 0.0, -0.3, 0.0, 1.5, 0.8])
    scene = Scene().attached("red", T_TOOL_RED, 0.05)
    unaware = workspace.world.checker(scene, margin=0.0)
    checker = load_aware(workspace, scene, unaware)
    assert unaware.edge_free(near, far)
    assert checker.free(near) and not checker.free(far) and not checker.edge_free(near, far)
    assert checker.fingerprint != unaware.fingerprint
    light = red(1.0)
    assert load_aware(light, scene, unaware) is unaware


def test_what_is_too_heavy_to_be_slid_is_not_slid():
    workspace = workspace_of(BOX)
    slide = next(plan_sliding(ToldContext(workspace), "box", workspace.start["box"]))[-1]
    ahead = np.subtract(slide.end.pose.xyz, slide.start.pose.xyz)
    assert push_too_heavy(workspace, "box", ahead, slide.opening, slide.push, 0.5) is None
    heavy = push_too_heavy(workspace_of(replace(BOX, mass=300.0)), "box", ahead, slide.opening, slide.push, 0.5)
    assert heavy is not None and "to push box asks" in heavy
    context = ToldContext(workspace_of(replace(BOX, mass=300.0)))
    assert next(plan_sliding(context, "box", context.scene.start["box"]), None) is None


def test_a_bar_is_not_turned_level_in_the_hand_where_it_would_swing_down():
    bar = replace(RED, shape=Box((0.03, 0.03, 0.26)), mass=0.8)
    hanging = Pose.from_rpy((0.0, 0.0, 0.11), (np.pi, 0.0, 0.0)).inverse().matrix
    carried = Carried(workspace_of(bar), "red", hanging, 0.03)
    down = np.array(panda().home)
    level = down + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.2, 0.0])
    assert carried.too_heavy(down[None]) is None
    assert carried.too_heavy(np.array([down, level])) == "red would slip or swing down in the fingers"


def test_what_friction_hardly_carries_is_lifted_slowly():
    def lifted_in(mass):
        workspace = workspace_of(replace(RED, mass=mass))
        q = next(iter(taken(workspace)[0]))[2].lift
        held = Attachment("red", FROM_ABOVE.T_object_tool.inverse())
        return Timing(workspace, {}).move("lift", q, 0.05, held).trajectory.duration

    assert lifted_in(0.1) < lifted_in(5.8)
