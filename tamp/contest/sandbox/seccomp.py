"""System calls that a solution does not get: what outlives it, leads out of it, or only widens what could be broken.

Namespaces do not reach everything: keys in the kernel's keyrings stay when a process has gone and are seen by the next
one; sockets to the machine that a virtual machine runs on know no network namespace; memory in files without a name, in
pages lent to pipes, in locks, in sets of rules and in messages without a connection counts for nobody; descriptors that
epoll waits for or that lie in messages count for the server's own user; all disks of the machine can be made to write.
A filter in the language of the Berkeley packet filter refuses these calls with EPERM. What has a disk write at once, or
drop what it has read, is answered as if it were done: what a solution writes is in memory, but asked of a file of the
system it is all users' disk that empties its cache, thousands of times a second. What sockets there are lie
between a solution's own processes, with queues of the usual length.
"""

from __future__ import annotations

import errno
import fcntl
import os
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from tamp.errors import TampError

Instruction = tuple[int, int, int, int]
"""Code, jump where true, jump where false, operand; see linux/filter.h."""

LOAD, EQUAL, AT_LEAST, RETURN, AND = 0x20, 0x15, 0x35, 0x06, 0x54
NUMBER, ARCHITECTURE, ARGUMENTS = 0, 4, (16, 24, 32)
"""Where they are in what the kernel shows the filter (struct seccomp_data; both machines are little-endian)."""
ALLOW, KILL, REFUSE, DONE = 0x7FFF0000, 0x80000000, 0x00050000 | errno.EPERM, 0x00050000

FAMILIES = (socket.AF_UNIX,)
"""Sockets that there are: there is no network, and what its sockets keep for themselves counts for nobody."""

KINDS, KIND_BITS = (socket.SOCK_STREAM, socket.SOCK_SEQPACKET), 0xF
"""Those with a connection, in which only the other end's queue can be; the other bits are flags."""

SO_SNDBUFFORCE = 32
QUEUES = (socket.SO_SNDBUF, SO_SNDBUFFORCE)
"""Options of sockets that make their queues longer than `tamp.contest.sandbox.process` takes them to be."""

F_SETPIPE_SZ = 1031
KEEPING = (6, 7, 37, 38, fcntl.F_SETLEASE, fcntl.F_NOTIFY, F_SETPIPE_SZ)
"""Commands of fcntl by which the kernel keeps something for a part of a file: F_SETLK, F_SETLKW, F_OFD_SETLK(W), ...;
and more for a pipe than `tamp.contest.sandbox.process` takes it to be."""

PR_SET_SECCOMP = 22
CORE = 4
"""RLIMIT_CORE, whose limit stays: see `tamp.contest.sandbox.isolation.NO_CORE`."""

NEW = {
    "io_uring_setup": 425, "io_uring_enter": 426, "io_uring_register": 427, "open_tree": 428, "move_mount": 429,
    "fsopen": 430, "fsconfig": 431, "fsmount": 432, "fspick": 433, "pidfd_getfd": 438, "mount_setattr": 442,
    "quotactl_fd": 443, "landlock_create_ruleset": 444, "memfd_secret": 447,
}  # fmt: skip
"""Calls that have the same number on all machines."""


@dataclass(frozen=True)
class Machine:
    """A kind of processor.

    Attributes:
        audit: what the kernel calls it (linux/audit.h).
        refused: name -> number of each call that is refused.
        answered: numbers of fsync, fdatasync, msync and fadvise64, which return 0 and do nothing.
        sockets: numbers of socket and socketpair.
        options: number of setsockopt.
        control: numbers of fcntl and prctl.
        limits: numbers of setrlimit and prlimit64.
        highest: calls from this number on are of another convention, and refused; None where there is none.
    """

    audit: int
    refused: Mapping[str, int]
    answered: tuple[int, ...]
    sockets: tuple[int, int]
    options: int
    control: tuple[int, int]
    limits: tuple[int, int]
    highest: int | None = None


MACHINES: Mapping[str, Machine] = MappingProxyType(
    {
        "x86_64": Machine(
            0xC000003E,
            {
                "sync": 162, "syncfs": 306, "sendmsg": 46, "sendmmsg": 307,
                "shmget": 29, "semget": 64, "msgget": 68, "ptrace": 101, "syslog": 103, "personality": 135,
                "pivot_root": 155, "chroot": 161, "acct": 163, "mount": 165, "umount2": 166, "swapon": 167,
                "swapoff": 168, "reboot": 169, "init_module": 175, "delete_module": 176, "quotactl": 179,
                "io_setup": 206, "epoll_create": 213, "mq_open": 240, "kexec_load": 246, "add_key": 248,
                "request_key": 249, "keyctl": 250,
                "inotify_init": 253, "migrate_pages": 256, "unshare": 272, "vmsplice": 278, "move_pages": 279,
                "epoll_create1": 291, "inotify_init1": 294,
                "perf_event_open": 298, "fanotify_init": 300, "open_by_handle_at": 304, "setns": 308,
                "process_vm_readv": 310, "process_vm_writev": 311, "kcmp": 312, "finit_module": 313,
                "seccomp": 317, "memfd_create": 319, "kexec_file_load": 320, "bpf": 321, "userfaultfd": 323, **NEW,
            },
            (74, 75, 26, 221),
            (41, 53),
            54,
            (72, 157),
            (160, 302),
            highest=0x40000000,
        ),
        "aarch64": Machine(
            0xC00000B7,
            {
                "sync": 81, "syncfs": 267, "sendmsg": 211, "sendmmsg": 269,
                "io_setup": 0, "epoll_create1": 20, "inotify_init1": 26, "umount2": 39, "mount": 40, "pivot_root": 41,
                "chroot": 51, "quotactl": 60, "vmsplice": 75, "acct": 89, "personality": 92, "unshare": 97,
                "kexec_load": 104, "init_module": 105, "delete_module": 106, "syslog": 116, "ptrace": 117,
                "reboot": 142, "mq_open": 180, "msgget": 186, "semget": 190, "shmget": 194, "add_key": 217,
                "request_key": 218, "keyctl": 219, "swapon": 224, "swapoff": 225, "migrate_pages": 238,
                "move_pages": 239, "perf_event_open": 241, "fanotify_init": 262, "open_by_handle_at": 265,
                "setns": 268, "process_vm_readv": 270, "process_vm_writev": 271, "kcmp": 272, "finit_module": 273,
                "seccomp": 277, "memfd_create": 279, "bpf": 280, "userfaultfd": 282, "kexec_file_load": 294, **NEW,
            },
            (82, 83, 227, 223),
            (198, 199),
            208,
            (25, 167),
            (164, 261),
        ),
    }
)  # fmt: skip


def call_filter(machine: str | None = None) -> list[Instruction]:
    """The filter's program, for this machine or one of `MACHINES`; `tamp.contest.api.host` takes it on.

    Raises:
        TampError: where the numbers of this machine's system calls are not known.
    """
    name = machine or os.uname().machine
    if name not in MACHINES:
        raise TampError(f"solutions cannot be isolated on {name}; {' and '.join(MACHINES)} are known")
    known = MACHINES[name]
    program = [
        (LOAD, 0, 0, ARCHITECTURE),
        (EQUAL, 1, 0, known.audit),
        (RETURN, 0, 0, KILL),
        (LOAD, 0, 0, NUMBER),
    ]
    if known.highest is not None:
        program += [(AT_LEAST, 0, 1, known.highest), (RETURN, 0, 0, REFUSE)]
    for number in known.refused.values():
        program += [(EQUAL, 0, 1, number), (RETURN, 0, 0, REFUSE)]
    for number in known.answered:
        program += [(EQUAL, 0, 1, number), (RETURN, 0, 0, DONE)]
    families = [(EQUAL, len(FAMILIES) - place, 0, int(family)) for place, family in enumerate(FAMILIES)]
    kinds = [(EQUAL, len(KINDS) - place, 0, int(kind)) for place, kind in enumerate(KINDS)]
    asked = [
        (LOAD, 0, 0, ARGUMENTS[0]), *families, (RETURN, 0, 0, REFUSE), (LOAD, 0, 0, ARGUMENTS[1]),
        (AND, 0, 0, KIND_BITS), *kinds, (RETURN, 0, 0, REFUSE), (RETURN, 0, 0, ALLOW),
    ]  # fmt: skip
    of_sockets = [(EQUAL, 1, 0, known.sockets[0]), (EQUAL, 0, len(asked), known.sockets[1]), *asked]
    refused = [(EQUAL, len(QUEUES) - place, 0, option) for place, option in enumerate(QUEUES)]
    asked = [
        (LOAD, 0, 0, ARGUMENTS[1]), (EQUAL, 0, 1 + len(QUEUES), socket.SOL_SOCKET), (LOAD, 0, 0, ARGUMENTS[2]),
        *refused, (RETURN, 0, 0, ALLOW), (RETURN, 0, 0, REFUSE),
    ]  # fmt: skip
    of_options = [(EQUAL, 0, len(asked), known.options), *asked]
    commands, settings = known.control
    of_control = [*_without(commands, 1, KEEPING), *_without(settings, 0, (PR_SET_SECCOMP,))]
    of_control += _keeping_limit(CORE, *known.limits)
    return [*program, *of_sockets, *of_options, *of_control, (RETURN, 0, 0, ALLOW)]


def _keeping_limit(kind: int, setrlimit: int, prlimit: int) -> list[Instruction]:
    """Refuse to set a limit, by the call that only sets, and by the one that sets where it is given a new value."""
    given = ARGUMENTS[2]
    asked = [
        (LOAD, 0, 0, ARGUMENTS[1]), (EQUAL, 0, 4, kind), (LOAD, 0, 0, given), (EQUAL, 0, 3, 0),
        (LOAD, 0, 0, given + 4), (EQUAL, 0, 1, 0), (RETURN, 0, 0, ALLOW), (RETURN, 0, 0, REFUSE),
    ]  # fmt: skip
    return [*_without(setrlimit, 0, (kind,)), (EQUAL, 0, len(asked), prlimit), *asked]


def _without(call: int, place: int, values: tuple[int, ...]) -> list[Instruction]:
    """Refuse a call where its argument at a place is one of some values, and allow it else."""
    refused = [(EQUAL, len(values) - index, 0, value) for index, value in enumerate(values)]
    asked = [(LOAD, 0, 0, ARGUMENTS[place]), *refused, (RETURN, 0, 0, ALLOW), (RETURN, 0, 0, REFUSE)]
    return [(EQUAL, 0, len(asked), call), *asked]
