"""From an optimistic skeleton to real values: conflict-directed backjumping that names culprits and learns no-goods.

May import the model, sampling and grounding.
"""
