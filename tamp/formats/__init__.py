"""Other people's task files: in and, where it makes sense, out again."""
