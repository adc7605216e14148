"""The strategies by name: what the stream planner is asked, all goals at once or one part after another.

May import domains, streams, planning, world, checking and scoring.
"""
