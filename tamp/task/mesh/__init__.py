"""Mesh files as convex parts: read, judged, decomposed once, and kept by content.

May import the nouns of tamp.task.
"""
