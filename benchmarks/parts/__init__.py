"""What several benchmarks share: command line, tables of tasks, bodies and scenes, an independent word on paths."""
