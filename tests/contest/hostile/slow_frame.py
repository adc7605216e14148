"""idle: did nothing"""

import time


class Solution:
    def run(self, goal, robot):
        while True:
            robot._connection._channel._socket.sendall(b"T")
            time.sleep(1000)
