"""The robot as a physics engine needs it: hulls with inertia, joints, and the motors of its gripper.

May import tamp.world and tamp.task.
"""
