"""New tasks from scene graphs: objects of a library in relations that hold, settled, within reach, graded by level."""
