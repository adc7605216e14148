"""Arguments of the commands that show what is installed."""

from __future__ import annotations

import argparse
from pathlib import Path

from tamp.arguments.kinds import Commands, add_json, add_outside, command, replacement


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """`robots`, `domains`, `doctor`, `completion`."""
    for name, run, text in (
        ("robots", "listing:robots", "list the installed robots"),
        ("domains", "listing:domains", "list the installed domains with their actions and streams"),
        ("doctor", "doctor:doctor", "show versions, binaries and extras, and test the installation"),
    ):
        add_json(command(commands, name, run, text))
    completion = command(commands, "completion", "completion:completion", "print completion for a shell")
    completion.add_argument("shell", choices=("bash", "zsh", "tcsh"))
    completion.epilog = "bash: tamp completion bash > ~/.local/share/bash-completion/completions/tamp"


def add_samplers(commands: Commands[argparse.ArgumentParser]) -> None:
    """`samplers` and `samplers check`."""
    samplers = command(commands, "samplers", "listing:samplers", "list the streams and the samplers that serve them")
    samplers.add_argument("--domain", default="tabletop", metavar="NAME", help="default: tabletop")
    samplers.add_argument("--task", type=Path, metavar="TASK.yaml", help="show the samplers that this task asks for")
    samplers.add_argument("--sampler", type=replacement, action="append", default=[], metavar="NAME=MODULE:FUNCTION")
    add_json(samplers)
    text = "hold a sampler against its stream; exit status 1 where anything is wrong"
    kit = samplers.add_subparsers(metavar="check").add_parser("check", help=text, description=text)
    kit.add_argument("address", metavar="MODULE:FUNCTION")
    kit.add_argument("--stream", required=True, metavar="NAME")
    kit.add_argument("--domain", default="tabletop", metavar="NAME", help="default: tabletop")
    kit.add_argument("--task", type=Path, metavar="TASK.yaml", help="where to try it; default: built-in scenarios")
    kit.add_argument("--seed", type=int, default=0, metavar="N")
    add_outside(kit.add_argument)
    add_json(kit)
    kit.set_defaults(run="samplers:check")
