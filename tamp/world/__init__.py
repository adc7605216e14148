"""Meshes, robot model, collision, kinematics, paths and timing. Knows no PDDL."""
