"""The hand and one object: where it pinches it, where the fingers stop, how firmly it holds, where it has room.

May import tamp.world, tamp.task, and values, workspace, cache and surfaces.
"""
