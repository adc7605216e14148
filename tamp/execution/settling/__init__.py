"""Scenes at rest: where things come to stand, what carries what, and what comes to rest within its poses' rounding.

May import tamp.execution's simulators and monitor, and what that may import.
"""
