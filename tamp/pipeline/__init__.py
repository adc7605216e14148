"""The whole job: a task is settled, planned, checked, executed and scored."""
