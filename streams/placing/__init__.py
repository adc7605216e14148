"""Placements: where an object can be put, where it is put aside, and where it is put down to be regrasped.

May import tamp.world, tamp.task, and what pushing may, and pushing.
"""
