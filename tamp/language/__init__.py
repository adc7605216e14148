"""PDDL and stream PDDL: text to typed, immutable structures."""
