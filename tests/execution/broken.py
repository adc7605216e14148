engine = nothing_such  # noqa: F821
