"""Tasks, plans and poses as files: read without trust, written so that they read back to the last bit.

May import the nouns of tamp.task, and meshes.
"""
