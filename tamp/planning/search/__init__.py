"""Classical search behind the planner: Fast Downward, and a best-first search of its own, over ground problems.

May import the model, sampling and grounding.
"""
