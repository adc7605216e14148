"""A robot with cameras as a program works it that is told no poses: what it measures, and plans carried out by feel.

May import tamp.execution, tamp.world and tamp.task.
"""
