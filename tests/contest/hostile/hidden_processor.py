"""processor: used more than | died: signal"""

import os
import signal
import time
from contextlib import suppress


class Solution:
    def run(self, goal, robot):
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for children: the kernel forgets what they used
        while True:
            if os.fork() == 0:
                end = time.process_time() + 0.7
                while time.process_time() < end:
                    pass
                os._exit(0)
            with suppress(ChildProcessError):
                os.wait()
