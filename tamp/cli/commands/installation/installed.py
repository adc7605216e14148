"""`tamp domains` and `tamp completion`: what is installed."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tamp.cli.options import add_json, command
from tamp.cli.output import to_stdout, write_json
from tamp.cli.status import SOLVED

if TYPE_CHECKING:
    from tamp.cli.options import Commands


def add(commands: Commands) -> None:
    """`domains`, `completion`."""
    add_json(command(commands, "domains", domains, "list the installed domains with their actions and streams"))
    parser = command(commands, "completion", completion, "print completion for a shell")
    parser.add_argument("shell", choices=("bash", "zsh", "tcsh"))
    parser.epilog = "bash: tamp completion bash > ~/.local/share/bash-completion/completions/tamp"


def domains(options: argparse.Namespace) -> int:
    """Each domain's actions and streams."""
    from tamp.domains.catalog import domain_names, load_domain

    entries = [load_domain(name) for name in domain_names()]
    listed = [
        {"name": e.name, "actions": list(e.pddl.actions), "streams": [s.name for s in e.stream_file.streams]}
        for e in entries
    ]
    if not to_stdout(options):
        for entry in listed:
            print(entry["name"], file=options.out)
            for part in ("actions", "streams"):
                print(f"  {part}: {', '.join(entry[part])}", file=options.out)
    write_json(options, listed)
    return SOLVED


def completion(options: argparse.Namespace) -> int:
    """Print the script that teaches a shell the commands and their options."""
    import shtab

    print(shtab.complete(options.parser, options.shell), file=options.out)
    return SOLVED
