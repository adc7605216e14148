"""The exact collision check, by Pinocchio's broadphase, and bounds that answer before it must.

May import world.geometry, world.robot and world.motion.paths.
"""
