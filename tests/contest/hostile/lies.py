"""protocol: not finite"""

import numpy as np
from tamp.contest.api.wire import Message


class Solution:
    def run(self, goal, robot):
        channel = robot._connection._channel
        channel.send(Message("move_joints", 9, {"speed": 1.0}, {"q": np.full(7, np.nan)}))
        channel.receive()
