"""Isolation by user namespaces through `unshare` of util-linux, where there is no bubblewrap."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from tamp.contest.sandbox import jail
from tamp.contest.sandbox.isolation import DEVICES, Room


class Namespaces:
    """The same walls as bubblewrap's, built by `tamp.contest.sandbox.jail`."""

    name = "namespaces"
    isolates = True

    def missing(self) -> str:
        """Why it cannot be used: no `unshare`, or a kernel that refuses user namespaces or their mounts."""
        if shutil.which("unshare") is None:
            return "the program unshare of util-linux is not installed"
        probe = [*self._unshare(), sys.executable, "-I", "-S", jail.__file__, _order(Room((), scratch_mb=1)), "--probe"]
        tried = subprocess.run(probe, capture_output=True, text=True)
        return "" if tried.returncode == 0 else f"unshare fails: {tried.stderr.strip()[-200:]}"

    def command(self, room: Room, command: Sequence[str]) -> list[str]:
        """See `Sandbox.command`."""
        python = str(Path(sys.executable).resolve())
        return [*self._unshare(), python, "-I", "-S", jail.__file__, _order(room), *command]

    def inside(self, room: Room, target: str) -> str:
        """Where it was mounted."""
        return target

    def _unshare(self) -> list[str]:
        spaces = ["--user", "--map-root-user", "--mount", "--pid", "--net", "--ipc", "--uts", "--cgroup"]
        return ["unshare", *spaces]


def _order(room: Room) -> str:
    """A room as JSON for the jail's command line."""
    mounts = [[str(mount.source), mount.target] for mount in room.mounts]
    shown = {"mounts": mounts, "hidden": room.hidden, "links": room.links, "devices": DEVICES}
    return json.dumps({**shown, "scratch_mb": room.scratch_mb})
