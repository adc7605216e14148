"""What the `tamp` command's subcommands take: one module a family of commands, each an `add(commands)`.

Nothing here imports what a command does: `run` names its function as "module:function" within tamp.commands.
"""
