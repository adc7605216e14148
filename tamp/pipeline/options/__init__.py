"""What decides a run beside its task: settings, the numbers in them that a user may change, and whose code is trusted.

May import tamp.clock, tamp.domains, tamp.execution's names of simulators, tamp.planning and tamp.task.
"""
