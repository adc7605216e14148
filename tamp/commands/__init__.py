"""What the `tamp` command's subcommands do, one function each: from parsed options to an exit status."""
