"""The way out to a real robot: what is asked of its controller, a plan carried out by one, and a dry run.

No driver for any hardware comes along.
"""
