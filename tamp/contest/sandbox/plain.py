"""No isolation: limits and an end with all children, for machines that offer no more, where the user insists."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from tamp.contest.sandbox import reaper
from tamp.contest.sandbox.isolation import Room


class Plain:
    """An ordinary process, under one that adopts whatever it leaves behind."""

    name = "none"
    isolates = False

    def missing(self) -> str:
        """Nothing: it can be used anywhere."""
        return ""

    def command(self, room: Room, command: Sequence[str]) -> list[str]:
        """See `Sandbox.command`."""
        return [str(Path(sys.executable).resolve()), "-I", "-S", reaper.__file__, *command]

    def inside(self, room: Room, target: str) -> str:
        """Where it is outside."""
        for mount in reversed(room.mounts):
            if target == mount.target or target.startswith(f"{mount.target}/"):
                return str(mount.source) + target[len(mount.target) :]
        return target
