"""The whole job of a task: planned, executed, repaired where reality deviates, scored, and reported to whoever asked.

May import the rest of tamp.pipeline and what that may import.
"""
