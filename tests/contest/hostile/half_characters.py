"""protocol: half a character"""

from tamp.contest.api.wire import Message


class Solution:
    def run(self, goal, robot):
        channel = robot._connection._channel
        channel.send(Message("tf", 9, {"parent": "\ud800", "child": "world"}))
        channel.receive()
