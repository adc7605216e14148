"""raised: HostileError"""


class HostileError(Exception):
    pass


class Solution:
    def run(self, goal, robot):
        raise HostileError("\x1b[2J\x1b]0;owned\x07 \ud800 \u202e \0 \n<script>alert(1)</script>")
