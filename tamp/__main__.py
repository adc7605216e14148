"""`python -m tamp`."""

from tamp.cli.command_line import run

run()
