"""Domains: a PDDL domain, its streams, and the code that turns a Task into a planning problem."""
