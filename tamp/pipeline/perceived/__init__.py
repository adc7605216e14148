"""Rearranging a table without being told where anything is: look, estimate, plan, act, look again.

May import what tamp.pipeline may. `run` alone sees both the true world and the planning side; nothing else here does.
"""
