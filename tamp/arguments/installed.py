"""Arguments of the commands that show what is installed."""

from __future__ import annotations

import argparse

from tamp.arguments.kinds import Commands, command


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """`robots`, `domains`, `samplers`, `doctor`."""
    command(commands, "robots", "listing:robots", "list the installed robots")
    command(commands, "domains", "listing:domains", "list the installed domains and their streams")
    command(commands, "samplers", "listing:samplers", "list the streams and the samplers that serve them")
    command(commands, "doctor", "doctor:doctor", "show versions and binaries, and test the installation")
