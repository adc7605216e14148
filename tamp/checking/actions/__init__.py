"""One rule for each kind of action, and what rules are made of: motions, grips, releases, falls, pushes, collisions.

May import the other rooms of the checker; nothing of planner, world or samplers.
"""
