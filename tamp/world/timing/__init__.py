"""From a path to a trajectory: corners blended, timed by TOPPRA under the joints' limits.

May import world.motion.paths and world.robot.
"""
