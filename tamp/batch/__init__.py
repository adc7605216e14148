"""Many tasks, many workers, one results file."""
