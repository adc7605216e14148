"""Collision-free paths between configurations, by OMPL. Geometry, no time.

May import world.collision and world.robot.
"""
