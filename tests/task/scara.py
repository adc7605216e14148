"""An arm of four joints, whose hand hangs straight down wherever it is: URDF and robot.yaml as text."""

from __future__ import annotations

from pathlib import Path

BODY = '<link name="{}"><collision><origin xyz="{}"/><geometry><box size="{}"/></geometry></collision></link>'
BODIES = (
    ("column", "0 0 0.2", "0.1 0.1 0.38"),
    ("inner", "0.15 0 0.03", "0.28 0.06 0.04"),
    ("outer", "0.13 0 0.03", "0.24 0.06 0.04"),
    ("quill", "0 0 -0.1", "0.02 0.02 0.3"),
    ("palm", "0 0 0.03", "0.06 0.12 0.06"),
    ("left", "0 0.006 0.025", "0.02 0.012 0.05"),
    ("right", "0 -0.006 0.025", "0.02 0.012 0.05"),
)
JOINT = (
    '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><origin xyz="{}" rpy="{} 0 0"/><axis xyz="{}"/>'
    '<limit lower="{}" upper="{}" velocity="2" effort="150"/>{}</joint>'
)
JOINTS = (
    ("shoulder", "revolute", "column", "inner", "0 0 0.4", 0, "0 0 1", -2.9, 2.9, ""),
    ("elbow", "revolute", "inner", "outer", "0.3 0 0.06", 0, "0 0 1", -2.9, 2.9, ""),
    ("lift", "prismatic", "outer", "quill", "0.27 0 0", 3.141592653589793, "0 0 1", 0, 0.28, ""),
    ("wrist", "revolute", "quill", "palm", "0 0 0.06", 0, "0 0 1", -2.9, 2.9, ""),
    ("slide", "prismatic", "palm", "left", "0 0 0.06", 0, "0 1 0", 0, 0.035, ""),
    ("follow", "prismatic", "palm", "right", "0 0 0.06", 0, "0 -1 0", 0, 0.035, '<mimic joint="slide"/>'),
)
ARM = (
    f'<robot name="scara">{"".join(BODY.format(*b) for b in BODIES)}{"".join(JOINT.format(*j) for j in JOINTS)}</robot>'
)

ROBOT = """urdf: arm.urdf
base: {xyz: [-0.33, 0.0, 0.0], radius: 0.1}
arm:
  joints: [shoulder, elbow, lift, wrist]
  acceleration: 5
  jerk: 1000
  reach: [0.2, 0.5]
  home: [0.3, 0.8, 0.0, 0.0]
tool: {parent: palm, xyz: [0.0, 0.0, 0.085]}
gripper:
  joints: [slide]
  fingers: [left, right]
  stroke: 0.07
  force: 40.0
  axis: [0.0, 1.0, 0.0]
  pad: [0.012, 0.02, 0.05]
"""


def write(folder: Path, robot: str = ROBOT, arm: str = ARM) -> Path:
    """Write it to a folder; returns robot.yaml."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "arm.urdf").write_text(arm)
    (folder / "robot.yaml").write_text(robot)
    return folder / "robot.yaml"
