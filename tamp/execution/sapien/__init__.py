"""SAPIEN (PhysX on the processor) behind the simulator's protocol. The only room that knows its name.

May import tamp.world and tamp.task.
"""
