"""What is held to be true of a scene: estimates brought up to date look by look, at rest, and where to look next.

May import the rest of tamp.perception but data sets, tamp.execution, tamp.world and tamp.task.
"""
