"""output: printed more than"""


class Solution:
    def run(self, goal, robot):
        while True:
            print("x" * 100_000)
