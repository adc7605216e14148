"""Task and motion planning for a robot arm at a cluttered table."""
