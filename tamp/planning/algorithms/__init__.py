"""The algorithms: adaptive, focused and incremental, over one session that keeps facts, samples and failures.

May import all other rooms of the planner.
"""
