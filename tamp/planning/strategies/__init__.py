"""Strategies: which part of a problem the stream planner is asked next, by name. They know no robot.

May import everything else of the planner but `solve`.
"""
