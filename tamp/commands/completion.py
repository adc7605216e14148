"""`tamp completion`."""

from __future__ import annotations

import argparse

from tamp.cli import SOLVED, parser


def completion(options: argparse.Namespace) -> int:
    """Print the script that teaches a shell the commands and their options."""
    import shtab

    print(shtab.complete(parser(), options.shell))
    return SOLVED
