"""Problems in PDDLStream's form, of our own making; `benchmarks.pddlstream_like` solves them."""
