"""The first program in new namespaces: builds the root, gives every power up, runs the command, and reaps.

A program of its own, since it is run by a bare interpreter before there is anything to import. Its child is process
1 of the process namespace: when that one ends, the kernel ends all others there.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path

MS_NOSUID, MS_NODEV, MS_NOEXEC, MS_BIND, MS_REC, MS_PRIVATE = 2, 4, 8, 4096, 16384, 1 << 18
MNT_DETACH = 2
READ_ONLY, NO_SUID, NO_DEVICES = 1, 2, 4
AT_RECURSIVE, AT_FDCWD = 0x8000, -100
PR_SET_PDEATHSIG, PR_CAPBSET_DROP, PR_SET_NO_NEW_PRIVS = 1, 24, 38
MOUNT_SETATTR, PIVOT_ROOT, CAPSET = 442, 155, 126
"""Numbers of system calls on x86-64; `run` corrects them for arm64."""

LIBC = ctypes.CDLL(None, use_errno=True)


class MountAttributes(ctypes.Structure):
    """struct mount_attr."""

    _fields_ = [(name, ctypes.c_uint64) for name in ("set", "clear", "propagation", "userns")]


def _checked(result: int, what: str) -> None:
    if result != 0:
        number = ctypes.get_errno()
        raise OSError(number, f"{what}: {os.strerror(number)}")


def _mount(source: str, target: str, kind: str, flags: int, data: str = "") -> None:
    encoded = [text.encode() for text in (source, target, kind)]
    _checked(LIBC.mount(*encoded, ctypes.c_ulong(flags), data.encode() or None), f"mount {target}")


def _lock(target: str, number: int, flags: int = READ_ONLY | NO_SUID | NO_DEVICES) -> None:
    """Make a mount and those under it read-only, whatever flags it came with."""
    attributes = MountAttributes(flags, 0, 0, 0)
    size = ctypes.sizeof(attributes)
    done = LIBC.syscall(number, AT_FDCWD, target.encode(), AT_RECURSIVE, ctypes.byref(attributes), size)
    _checked(done, f"mount_setattr {target}")


def _show(source: str, root: str, target: str, number: int) -> None:
    place = Path(root + target)
    if Path(source).is_dir():
        place.mkdir(parents=True, exist_ok=True)
    else:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.touch()
    _mount(source, str(place), "", MS_BIND | MS_REC)
    _lock(str(place), number)


def build(order: dict[str, object], mount_setattr: int, pivot_root: int) -> None:
    """Put the process into a root that holds what the order says, and nothing else."""
    root = "/tmp"
    _mount("none", "/", "", MS_REC | MS_PRIVATE)
    # The sources are held open beforehand: one of them may lie under the new root's mount point.
    held = [(os.open(source, os.O_PATH), target) for source, target in order["mounts"]]  # type: ignore[attr-defined]
    devices = [(os.open(f"/dev/{name}", os.O_PATH), f"/dev/{name}") for name in order["devices"]]  # type: ignore[attr-defined]
    _mount("tmpfs", root, "tmpfs", MS_NOSUID | MS_NODEV, "size=1m,mode=755")
    # Before what is shown: the interpreter itself may lie under /tmp.
    Path(root, "tmp").mkdir()
    _mount("tmpfs", root + "/tmp", "tmpfs", MS_NOSUID | MS_NODEV, f"size={order['scratch_mb']}m,mode=777")
    for descriptor, target in held:
        _show(f"/proc/self/fd/{descriptor}", root, target, mount_setattr)
    for folder in order["hidden"]:  # type: ignore[attr-defined]
        _mount("tmpfs", root + folder, "tmpfs", MS_NOSUID | MS_NODEV, "size=4k,mode=555")
    for place, target in order["links"]:  # type: ignore[attr-defined]
        Path(root + place).parent.mkdir(exist_ok=True)
        Path(root + place).symlink_to(target)
    for descriptor, target in devices:
        place = Path(root + target)
        place.parent.mkdir(exist_ok=True)
        place.touch()
        _mount(f"/proc/self/fd/{descriptor}", str(place), "", MS_BIND)
    for name in ("proc", "old"):
        Path(root, name).mkdir(exist_ok=True)
    for descriptor, _ in held + devices:
        os.close(descriptor)
    _mount("proc", root + "/proc", "proc", MS_NOSUID | MS_NODEV | MS_NOEXEC)
    Path(root, "proc/sys/user/max_user_namespaces").write_text("0")
    # Where the server runs as root, the kernel lets its user write settings: nothing under /proc is writable.
    _lock(root + "/proc", mount_setattr)
    _checked(LIBC.syscall(pivot_root, root.encode(), (root + "/old").encode()), "pivot_root")
    os.chdir("/")
    _checked(LIBC.umount2(b"/old", MNT_DETACH), "umount")
    Path("/old").rmdir()
    attributes = MountAttributes(READ_ONLY | NO_SUID | NO_DEVICES, 0, 0, 0)
    done = LIBC.syscall(mount_setattr, AT_FDCWD, b"/", 0, ctypes.byref(attributes), ctypes.sizeof(attributes))
    _checked(done, "mount_setattr /")
    os.chdir("/tmp")


def give_up_powers(capset: int) -> None:
    """No capabilities, none to be had from any program, and no new privileges."""
    capability = 0
    while LIBC.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0) == 0:
        capability += 1
    _checked(LIBC.prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), "no_new_privs")
    header = (ctypes.c_uint32 * 2)(0x20080522, 0)
    _checked(LIBC.syscall(capset, header, (ctypes.c_uint32 * 6)()), "capset")


def main(arguments: Sequence[str]) -> int:
    """Become the namespace's first process; the exit status is the command's, or 128 and a signal's number."""
    _checked(LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0), "parent death signal")
    first = os.fork()
    if first == 0:
        _checked(LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0), "parent death signal")
        os._exit(run(arguments))
    _close_all()
    return _status(os.waitpid(first, 0)[1])


def run(arguments: Sequence[str]) -> int:
    """Build the room, give all powers up, run the command, and wait for it and for whoever is orphaned."""
    numbers = (442, 41, 91) if os.uname().machine == "aarch64" else (MOUNT_SETATTR, PIVOT_ROOT, CAPSET)
    order, *command = arguments
    try:
        build(json.loads(order), numbers[0], numbers[1])
        give_up_powers(numbers[2])
    except OSError as error:
        print(f"the sandbox cannot be built: {error}", file=sys.stderr, flush=True)
        return 125
    if command == ["--probe"]:
        return 0
    child = os.fork()
    if child == 0:
        os.setsid()
        os.execv(command[0], command)
    _close_all()
    while True:
        pid, status = os.wait()
        if pid == child:
            return _status(status)


def _close_all() -> None:
    """The socket is the command's alone: it closes when the command has gone."""
    os.closerange(3, 1024)


def _status(status: int) -> int:
    return os.WEXITSTATUS(status) if os.WIFEXITED(status) else 128 + os.WTERMSIG(status)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
