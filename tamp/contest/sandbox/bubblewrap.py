"""Isolation by bubblewrap, the program that Flatpak runs applications with."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence

from tamp.contest.sandbox.isolation import DEVICES, Room


class Bubblewrap:
    """New namespaces of all kinds, an own root of read-only mounts, no capabilities, no way to gain any."""

    name = "bubblewrap"
    isolates = True

    def missing(self) -> str:
        """Why it cannot be used: it is not installed, or the kernel refuses it."""
        if shutil.which("bwrap") is None:
            return "the program bwrap is not installed"
        tried = subprocess.run(["bwrap", *self._walls(), "--ro-bind", "/", "/", "true"], capture_output=True, text=True)
        return "" if tried.returncode == 0 else f"bwrap fails: {tried.stderr.strip()[:200]}"

    def command(self, room: Room, command: Sequence[str]) -> list[str]:
        """See `Sandbox.command`."""
        # /tmp comes before what is shown: the interpreter itself may lie under it.
        made = ["bwrap", *self._walls(), "--size", str(room.scratch_mb << 20), "--tmpfs", "/tmp"]
        for mount in room.mounts:
            made += ["--ro-bind", str(mount.source), mount.target]
        for folder in room.hidden:
            made += ["--tmpfs", folder, "--remount-ro", folder]
        for place, target in room.links:
            made += ["--symlink", target, place]
        # Where the server runs as root, the kernel would let its user write settings: /proc is read-only.
        made += ["--proc", "/proc", "--remount-ro", "/proc"]
        # Not all of /dev: of terminals there are but so many on a machine, and their memory counts for nobody.
        made += [word for name in DEVICES for word in ("--dev-bind", f"/dev/{name}", f"/dev/{name}")]
        return [*made, "--chdir", "/tmp", "--remount-ro", "/", "--", *command]

    def inside(self, room: Room, target: str) -> str:
        """Where it was mounted."""
        return target

    def _walls(self) -> list[str]:
        spaces = ["--unshare-all", "--unshare-user", "--disable-userns"]
        return [*spaces, "--die-with-parent", "--new-session", "--cap-drop", "ALL"]
