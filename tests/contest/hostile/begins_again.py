"""protocol: hello comes first, and once"""

from tamp.contest.api.wire import Message


class Solution:
    def run(self, goal, robot):
        channel = robot._connection._channel
        for number in (1, 1, -(10**30)):  # numbers of calls that there were, and never will be
            channel.send(Message("state", number))
        channel.send(Message("hello", 1, {"version": 1}))
        while True:
            channel.receive()
