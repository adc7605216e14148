"""Pick, place and unstack at a table."""
