"""The robot as the planner computes with it: model, chain, hulls, hand.

May import world.geometry.
"""
