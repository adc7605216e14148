"""The order of goals: which part of a task the stream planner is asked next, and what is done where it fails.

May import subproblems, domains, streams, planning, world, checking and scoring.
"""
