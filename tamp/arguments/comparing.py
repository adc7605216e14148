"""Arguments of `tamp compare`."""

from __future__ import annotations

import argparse
from pathlib import Path

from tamp.arguments.kinds import Commands, add_algorithm, add_json, add_outside, command, natural, seconds
from tamp.arguments.solving import add_batch_options


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """`compare`."""
    text = "solve the same tasks with different samplers and show the differences with confidence intervals"
    compare = command(commands, "compare", "compare:compare", text)
    add = compare.add_argument
    add("tasks", nargs="+", type=Path, metavar="TASK.yaml")
    add(
        "--sampler",
        type=contender,
        action="append",
        required=True,
        metavar="CONTENDER",
        help="NAME=MODULE:FUNCTION, several of them joined by commas, or 'default'; the first is what others are held "
        "against",
    )
    add("--seed", type=natural, action="append", metavar="N", help="repeat it for several seeds; default 0")
    add("--timeout", type=seconds, metavar="SECONDS", help="for all planning of a task; default: the task's own limit")
    add_algorithm(add)
    add("--no-execute", action="store_true", help="only plan and check")
    add("--output", type=Path, metavar="DIR", required=True, help="a folder of results each, and comparison.html")
    add_batch_options(compare)
    add_outside(add)
    add_json(compare)


def contender(text: str) -> tuple[str, dict[str, str]]:
    """What is compared: its name as it was given, and the samplers that it replaces."""
    if text == "default":
        return text, {}
    replaced = {}
    for part in text.split(","):
        stream, equals, address = part.partition("=")
        if not stream or not equals or ":" not in address:
            raise argparse.ArgumentTypeError(f"{text} is neither 'default' nor of the form NAME=MODULE:FUNCTION,...")
        replaced[stream] = address
    return text, replaced
