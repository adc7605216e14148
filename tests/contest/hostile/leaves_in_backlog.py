"""memory: used more than"""

import socket, time


class Solution:
    def run(self, goal, robot):
        with socket.socket(socket.AF_UNIX) as listening:
            listening.bind("/tmp/socket")
            listening.listen(4000)
            for _ in range(4000):  # what was sent waits for who never accepts, though its sender is closed
                with socket.socket(socket.AF_UNIX) as sender:
                    sender.setblocking(False)
                    try:
                        sender.connect("/tmp/socket")
                        while True:
                            sender.send(bytes(1 << 16))
                    except OSError:
                        pass
            time.sleep(1000)
