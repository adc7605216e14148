"""Grasps of an object: candidates in open space or in a container, ranked by the placements and neighbours they serve.

May import tamp.world, tamp.task, and what motion may, and motion.
"""
