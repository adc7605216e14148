"""raised: FileNotFoundError"""

from pathlib import Path


class Solution:
    def run(self, goal, robot):
        print(Path("/etc/passwd").read_text())
