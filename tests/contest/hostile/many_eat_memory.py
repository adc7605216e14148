"""memory: used more than"""

import os, time


class Solution:
    def run(self, goal, robot):
        for _ in range(8):
            if os.fork() == 0:
                kept = bytearray(b"x" * (100 << 20))
                time.sleep(60)
        time.sleep(60)
