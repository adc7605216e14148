"""Rigid bodies of convex parts, their distances, and transforms, by the checker's own means.

May import numpy, python-fcl and scipy only.
"""
