"""Parts of a task that the stream planner is asked one after another, and the plan that their solutions make.

May import domains, streams, planning, world, checking and scoring.
"""
