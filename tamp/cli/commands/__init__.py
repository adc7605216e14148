"""The families of commands: each module has `add(commands)`, and beside it what its commands do.

A function takes the parsed options and returns an exit status; what was asked for it prints to `options.out`
(`options.parser` is the whole command line). A new family is one module in one of the folders, named in
`tamp.cli.command_line`.
"""
