"""The problem as the planner sees it: normal forms, schemas, facts, stream instances, states.

May import the PDDL language; no other room of the planner.
"""
