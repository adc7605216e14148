"""protocol: there is no message 'place'"""

from tamp.contest.api.wire import Message


class Solution:
    def run(self, goal, robot):
        channel = robot._connection._channel
        channel.send(Message("place", 9, {"object": "red"}))
        channel.receive()
