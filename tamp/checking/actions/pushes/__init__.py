"""What a hand does to what it pushes: pushes along the table, nudges within a container, topples over an edge.

May import what rules are made of beside it, and the other rooms of the checker.
"""
