"""memory: used more than | memory: made more than"""

import os


class Solution:
    def run(self, goal, robot):
        number = 0
        while True:
            number += 1
            os.close(os.open(f"/tmp/{number}", os.O_CREAT))
