"""memory: used more than"""

import os, time


class Solution:
    def run(self, goal, robot):
        for _ in range(8):
            if os.fork() == 0:
                until = time.monotonic() + 3
                while time.monotonic() < until:  # whoever looks at processes sees some that have just ended
                    if os.fork() == 0:
                        os._exit(0)
                    os.wait()
                kept = bytearray(80 << 20)
                time.sleep(1000)
        time.sleep(1000)
