"""protocol: bytes"""

import struct


class Solution:
    def run(self, goal, robot):
        robot._connection._channel._socket.sendall(struct.pack("!4sII", b"TC01", 10, 2**32 - 1) + b"0" * 1000)
        robot._connection._channel._socket.recv(1)
