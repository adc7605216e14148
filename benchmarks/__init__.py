"""What the framework must show, measured: `python -m benchmarks.NAME [--quick] [--json FILE]`."""
