"""Places for things: their outlines, what they may touch, and what each relation means, by geometry alone.

May import tamp.world, tamp.scenarios and tamp.task.
"""
