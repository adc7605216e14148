"""raised: OSError"""


class Solution:
    def run(self, goal, robot):
        for number in range(100):
            with open(f"/tmp/{number}", "wb") as file:
                file.write(bytes(1 << 20))
