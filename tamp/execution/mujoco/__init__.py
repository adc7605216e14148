"""MuJoCo behind the simulator's protocol: world, bodies, robot. The only room that knows its name.

May import tamp.world and tamp.task.
"""
