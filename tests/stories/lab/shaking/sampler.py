"""Where the arm shakes what it holds, and how."""

import numpy as np

from tamp.sampling import ArmPath, Configuration, Pose, Scene, inverse, moved, straight_line

HIGH = (0.0, 0.0, 0.25)  # over the table, where there is room [m]
SWING = 0.06  # to the side [m]


def plan_shake(context, obj, grasp):
    """Yield a configuration high over the table, and twice to the side and back with the object upright."""
    workspace = context.scene
    robot = workspace.world.robot
    poses = {name: place.pose.matrix for name, place in workspace.start.items() if name != obj}
    scene = Scene(poses).attached(obj, grasp.T_object_tool.inverse().matrix, grasp.width)
    checker = workspace.world.checker(scene)
    for yaw in context.rng.uniform(-np.pi, np.pi, 8):
        upright = Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, yaw)).matrix @ workspace.start[obj].pose.matrix
        upright[:3, 3] = HIGH
        tool = upright @ grasp.T_object_tool.matrix
        for q in inverse(robot, tool, context.rng, checker=checker, count=2):
            side = straight_line(robot, q, moved(tool, np.array([0.0, SWING, 0.0])))
            if side is not None and checker.path_free(side):
                back = side[-2::-1]
                yield Configuration(tuple(q), grasp.width), ArmPath(np.concatenate([side, back, side[1:], back]))
    context.fail(f"nowhere to shake {obj}")
