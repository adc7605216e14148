"""Poses of known objects from depth and colour, without learning: fuse, guess, fit, and choose for all at once.

May import tamp.world and tamp.task; knows nothing of simulators or renderers beyond what a body looks like.
"""
