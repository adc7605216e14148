"""Inverse kinematics: many configurations for a tool pose, and straight lines of the tool.

May import world.robot.
"""
