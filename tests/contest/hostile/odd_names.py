"""memory: used more than"""

import ctypes, os, time


class Solution:
    def run(self, goal, robot):
        for _ in range(12):
            if os.fork() == 0:
                ctypes.CDLL(None).prctl(15, b"\xff) R 1\n\xfe", 0, 0, 0)  # what /proc calls it, in no encoding
                kept = bytearray(80 << 20)
                time.sleep(1000)
        time.sleep(1000)
