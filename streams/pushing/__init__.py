"""Pushing what no hand can grasp as it lies: slides over the table's edge, topples, nudges, and the grasp after them.

May import tamp.world, tamp.task, and what releasing may, and releasing.
"""
