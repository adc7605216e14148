"""What can be done with an object, by its geometry and its neighbours': grasp, lay, drop, slide, topple or nudge it.

May import tamp.world, tamp.task, tamp.execution, and what hand may, hand, and collisions.
"""
