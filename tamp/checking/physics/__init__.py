"""Contacts, equilibrium with friction, and whether things stay where they stand.

May import the checker's geometry, scene and tolerances.
"""
