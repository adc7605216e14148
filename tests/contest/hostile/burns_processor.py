"""processor: used more than | died: signal"""


class Solution:
    def run(self, goal, robot):
        while True:
            pass
