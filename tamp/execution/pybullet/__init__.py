"""PyBullet behind the simulator's interface: world, bodies, robot. The only room that knows its name.

May import tamp.world and tamp.task.
"""
