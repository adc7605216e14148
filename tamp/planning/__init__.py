"""The stream planner. Knows no robot."""
