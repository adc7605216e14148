"""Letting go before the end: tilted releases and drops, and what the object does until it lies.

May import tamp.world, tamp.task, tamp.execution, and what grasping may, and grasping.
"""
