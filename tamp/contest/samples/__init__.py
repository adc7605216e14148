"""Solutions to begin with; each a single file that `tamp contest run` takes by name or path."""
