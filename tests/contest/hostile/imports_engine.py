"""raised: ModuleNotFoundError"""


class Solution:
    def run(self, goal, robot):
        import pybullet
