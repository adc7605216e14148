"""protocol: an array is described by"""

from tamp.contest.api.wire import PREFIX


class Solution:
    def run(self, goal, robot):
        socket = robot._connection._channel._socket
        header = b'{"kind":"state","number":9,"fields":{},"arrays":[["q","f8",[0,2147483647,2147483647]]]}'
        socket.sendall(PREFIX.pack(b"TC01", len(header), 0) + header)
        socket.recv(1)
