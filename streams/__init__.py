"""The samplers of the tabletop streams; each is a plain function that a researcher may replace."""
