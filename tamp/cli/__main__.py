"""`python -m tamp.cli`."""

from tamp.cli.command_line import run

run()
