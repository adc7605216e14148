"""Planning problems without a robot, one family a file. Each function returns a Problem."""
