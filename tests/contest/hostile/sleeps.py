"""wall: ran"""

import time


class Solution:
    def run(self, goal, robot):
        time.sleep(1000)
