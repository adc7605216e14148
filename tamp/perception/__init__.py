"""Seeing: cameras, rendered pictures with the noise of real sensors, and object poses estimated from them.

May import tamp.execution, tamp.streams, tamp.world, tamp.task, tamp.errors, tamp.clock and tamp.compiled.
"""
