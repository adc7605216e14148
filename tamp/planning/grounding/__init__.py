"""From schemas and facts to ground operators, and the proof that a goal can never come about.

May import the model and sampling.
"""
