"""Cameras as data: intrinsics, where they are mounted, how their depth errs, and the set-ups that are installed.

May import tamp.world and tamp.task.
"""
