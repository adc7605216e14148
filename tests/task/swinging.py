"""A robot whose fingers swing on parallel links, small enough to be reckoned by hand: URDFs and robot.yaml as text."""

from __future__ import annotations

import math
from pathlib import Path

RADIUS, ROOT, LEAN = 0.05, 0.01, 0.3
"""Of the swinging links: length [m], how far their axles are from the middle [m], how far they lean out [rad]."""

ARM = """<robot name="arm" xmlns:known="urn:known">
  <link name="base"><collision><geometry><box size="0.1 0.1 0.02"/></geometry></collision></link>
  <link name="column"><collision><origin xyz="0 0 0.1"/>
    <geometry><mesh filename="package://theirs/meshes/bar.obj" scale="0.001 0.001 0.001"/></geometry></collision>
    <visual><geometry><mesh filename="package://theirs/meshes/absent.dae"/></geometry></visual></link>
  <link name="boom"><collision><origin xyz="0 0 0.1"/>
    <geometry><box size="0.03 0.03 0.2"/></geometry></collision></link>
  <link name="flag"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="column"/><axis xyz="0 0 1"/>
    <origin xyz="0 0 0.02"/><limit effort="10" velocity="2" drake:acceleration="3"/></joint>
  <joint name="bend" type="revolute"><parent link="column"/><child link="boom"/><axis xyz="0 1 0"/>
    <origin xyz="0 0 0.25"/><limit lower="-2" upper="2" effort="10" velocity="2"/></joint>
  <joint name="wave" type="revolute"><parent link="base"/><child link="flag"/><axis xyz="0 0 1"/>
    <origin xyz="0.04 0 0"/><limit lower="0.5" upper="1" effort="1" velocity="1"/></joint>
  <gazebo reference="base"/>
</robot>"""

BAR = "v -15 -15 -90\nv 15 -15 -90\nv 0 15 -90\nv 0 0 90\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
"""A mesh in millimetres."""

FINGER = """
  <link name="{side}_bar"/>
  <link name="{side}_tip"><collision><origin xyz="0 {out} 0"/>
    <geometry><box size="0.01 0.004 0.02"/></geometry></collision></link>
  <joint name="{side}_swing" type="revolute"><parent link="palm"/><child link="{side}_bar"/><axis xyz="{axis} 0 0"/>
    <origin xyz="0 {root} 0.03"/><limit lower="0" upper="0.8" effort="9" velocity="2"/>{swing}</joint>
  <joint name="{side}_level" type="revolute"><parent link="{side}_bar"/><child link="{side}_tip"/>
    <axis xyz="{axis} 0 0"/><origin xyz="0 {y} {z}"/><limit lower="-1" upper="1" effort="9" velocity="2"/>
    <mimic joint="{follows}" multiplier="-1"/></joint>"""


def gripper() -> str:
    """The gripper's URDF: `left_swing` drives; its mirror mimics it, and both fingertips stay level."""
    sides = []
    for side, sign, swing, follows in (("left", 1, "", "left_swing"), ("right", -1, "left_swing", "right_swing")):
        values = {
            "side": side, "axis": sign, "root": sign * ROOT, "y": sign * RADIUS * math.sin(LEAN),
            "z": RADIUS * math.cos(LEAN), "out": sign * 0.002, "follows": follows,
            "swing": f'<mimic joint="{swing}"/>' if swing else "",
        }  # fmt: skip
        sides.append(FINGER.format(**values))
    palm = '<link name="palm"><collision><geometry><box size="0.03 0.04 0.02"/></geometry></collision></link>'
    return f'<robot name="hand">{palm}{"".join(sides)}</robot>'


ROBOT = """urdf: urdf/arm.urdf
meshes: [theirs_elsewhere]
base: {xyz: [-0.3, 0.0, 0.0], radius: 0.1}
arm:
  joints: [turn, bend]
  velocity: 1.5
  acceleration: 8
  jerk: [4000, 4000]
  reach: [0.2, 0.5]
  home: [0.0, 0.3]
tool: {parent: boom, xyz: [0.0, 0.0, 0.28]}
gripper:
  attach: {urdf: urdf/hand.urdf, parent: boom, xyz: [0.0, 0.0, 0.2], prefix: h_}
  joints: [h_left_swing]
  fingers: [h_left_tip, h_right_tip]
  pads: [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
  limits: [0.0, 0.5]
  stroke: 0.04
  force: 20.0
  axis: [0.0, 1.0, 0.0]
  pad: [0.004, 0.01, 0.018]
"""


def opening(driver: float) -> float:
    """The distance between the pads where the driver is at an angle [rad]; [m]."""
    return 2 * (ROOT + RADIUS * math.sin(LEAN - driver))


def depth(driver: float) -> float:
    """Where the pads are along the tool's z then [m]."""
    return 0.2 + 0.03 + RADIUS * math.cos(LEAN - driver) - 0.28


def write(folder: Path, robot: str = ROBOT, arm: str = ARM) -> Path:
    """All files of the robot; the path of its robot.yaml."""
    for name in ("urdf", "theirs_elsewhere/meshes"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    (folder / "urdf" / "arm.urdf").write_text(arm)
    (folder / "urdf" / "hand.urdf").write_text(gripper())
    (folder / "theirs_elsewhere" / "meshes" / "bar.obj").write_text(BAR)
    (folder / "robot.yaml").write_text(robot)
    return folder / "robot.yaml"
