"""raised: MemoryError | memory: used more than"""


class Solution:
    def run(self, goal, robot):
        kept = []
        while True:
            kept.append(bytearray(b"x" * (1 << 24)))
