"""What is installed, and whether it fits: domains, robots, samplers, completion, doctor."""
