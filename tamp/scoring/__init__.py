"""EDE and its relatives, and their baselines."""
