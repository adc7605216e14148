"""raised: nothing is taken from others"""

import _socket, array, ctypes, fcntl, os, select, socket

LIBC = ctypes.CDLL(None, use_errno=True)
MOST = 2000  # of timers: all that this user's processes may have lies far above


def terminal():
    return os.openpty()


def watches():
    with select.epoll() as poll:
        poll.register(os.pipe()[0])


def lock():
    with open("/tmp/file", "wb") as file:
        fcntl.lockf(file, fcntl.LOCK_EX, 1, 0)


def lease():
    with open("/tmp/file", "wb") as file:
        fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_WRLCK)


def timers():
    for _ in range(MOST):
        if LIBC.timer_create(1, None, ctypes.byref(ctypes.c_void_p())):
            raise OSError(ctypes.get_errno())


def filter_of_calls():
    allow = (ctypes.c_uint64 * 1)(0x7FFF000000000006)
    program = (ctypes.c_uint64 * 2)(1, ctypes.addressof(allow))
    if LIBC.prctl(22, 2, program):
        raise OSError(ctypes.get_errno())


def posted_descriptors():
    ends = socket.socketpair()
    posted = (socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [ends[1].fileno()]))
    _socket.socket.sendmsg(ends[0], [b"x"], [posted])  # that of socket.socket is hidden, the call is not


def disks():
    machine = int(os.uname().machine == "aarch64")
    done = [LIBC.syscall(162 - 81 * machine), LIBC.syscall(306 - 39 * machine, os.open("/usr", os.O_RDONLY))]
    if 0 not in done:
        raise OSError(ctypes.get_errno())


class Solution:
    def run(self, goal, robot):
        taken = []
        for take in (terminal, watches, lock, lease, timers, filter_of_calls, posted_descriptors, disks):
            try:
                take()
                taken.append(take.__name__)
            except OSError:
                pass
        raise RuntimeError(f"has {taken}" if taken else "nothing is taken from others")
