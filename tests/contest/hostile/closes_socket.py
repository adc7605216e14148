"""died: closed its socket"""

import socket
import time


class Solution:
    def run(self, goal, robot):
        robot._connection._channel._socket.shutdown(socket.SHUT_RDWR)
        time.sleep(1000)
