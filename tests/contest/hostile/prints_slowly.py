"""output: printed more than"""

import os, time


class Solution:
    def run(self, goal, robot):
        while True:
            for stream in (1, 2):
                os.write(stream, b"<script>alert(1)</script>'; DROP TABLE teams; --\n" * 10)
            time.sleep(0.01)
