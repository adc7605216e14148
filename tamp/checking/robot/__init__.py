"""The robot by the checker's own means: kinematics from the URDF, links as solids, sweeps, trajectory limits.

May import the checker's geometry.
"""
