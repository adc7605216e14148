"""protocol: no JSON"""

import struct


class Solution:
    def run(self, goal, robot):
        header = b"[" * 60_000
        robot._connection._channel._socket.sendall(struct.pack("!4sII", b"TC01", len(header), 0) + header)
        robot._connection._channel._socket.recv(1)
