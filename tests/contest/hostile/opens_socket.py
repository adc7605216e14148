"""raised: Errno"""

import socket


class Solution:
    def run(self, goal, robot):
        socket.create_connection(("127.0.0.1", PORT), timeout=2).sendall(b"out")


PORT = 22
