"""A robot's files: robot.yaml, the URDFs that it names, and whether they fit together."""
