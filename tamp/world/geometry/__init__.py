"""What objects are made of: convex parts, unions of them, and how they rest on a plane.

May import tamp.task.
"""
