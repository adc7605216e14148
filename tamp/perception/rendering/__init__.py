"""Pictures as cameras take them: colour, depth and which body each pixel shows, by two renderers that agree.

May import tamp.execution's rasterizer, tamp.world and tamp.task.
"""
