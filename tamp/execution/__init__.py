"""The simulator, and the executor that runs a timed plan in it."""
