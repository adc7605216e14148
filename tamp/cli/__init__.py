"""The `tamp` command: each family of commands is one module of `tamp.cli.commands`, its options beside its functions.

This room may import every other; nothing imports it. What a command does is imported only when it runs.
"""

from tamp.cli.command_line import main, parser, run

__all__ = ["main", "parser", "run"]
