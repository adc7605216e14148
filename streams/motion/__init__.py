"""Arm motions: inverse kinematics for taking and placing, lifts, and paths between configurations.

May import tamp.world, tamp.task, and what affordances may, and affordances.
"""
