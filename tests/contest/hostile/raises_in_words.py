"""raised: HostileError"""


class HostileError(BaseException):
    def __str__(self):
        raise SystemExit(0)


class Solution:
    def run(self, goal, robot):
        raise HostileError
