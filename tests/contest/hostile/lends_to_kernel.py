"""raised: the kernel keeps nothing"""

import ctypes, fcntl, os, socket

LIBC = ctypes.CDLL(None, use_errno=True)
PIPE, OTHER = os.pipe(), socket.socketpair()
PAGE = ctypes.create_string_buffer(b"x" * 4096)
LENT = (ctypes.c_size_t * 2)(ctypes.addressof(PAGE), 4096)
RULES, CONTEXT = (ctypes.c_uint64 * 2)(1, 0), ctypes.c_ulong(0)
CALLS = {  # what is kept for a process where no limit of its own counts it
    "pages in a pipe": ((278, 75), (PIPE[1], LENT, 1, 0)),
    "rules": ((444, 444), (RULES, 8, 0)),
    "a queue of requests": ((206, 0), (100, ctypes.byref(CONTEXT))),
}


class Solution:
    def run(self, goal, robot):
        machine = int(os.uname().machine == "aarch64")
        kept = [name for name, (numbers, given) in CALLS.items() if LIBC.syscall(numbers[machine], *given) >= 0]
        try:
            fcntl.fcntl(PIPE[1], 1031, 1 << 20)
            kept.append("a long pipe")
        except OSError:
            pass
        for option in (socket.SO_SNDBUF, 32):
            try:
                OTHER[0].setsockopt(socket.SOL_SOCKET, option, 1 << 22)
                kept.append("a long queue")
            except OSError:
                pass
        for make in (socket.socket, socket.socketpair):  # a receiver keeps what senders sent that are closed by now
            try:
                make(socket.AF_UNIX, socket.SOCK_DGRAM)
                kept.append("messages without a connection")
            except OSError:
                pass
        socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        OTHER[0].setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)
        raise RuntimeError(f"keeps {kept}" if kept else "the kernel keeps nothing")
