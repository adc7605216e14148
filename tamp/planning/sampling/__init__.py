"""Calling streams: outputs one at a time, tests evaluated lazily, rounds over what may be called.

May import the model.
"""
