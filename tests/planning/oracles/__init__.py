"""What judges the planner without it: a validator of plans, an exhaustive search, and the semantics both rest on."""
