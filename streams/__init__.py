"""The samplers of the tabletop streams; each is a plain function that a researcher may replace.

The rooms have an order, and each imports only those before it: hand, affordances, motion, grasping, releasing, pushing,
placing. All may import tamp.world and tamp.task, and tamp.execution to see where things come to rest.
"""
