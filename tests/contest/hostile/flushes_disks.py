"""raised: the disk is left alone"""

import ctypes, os

LIBC = ctypes.CDLL(None, use_errno=True)
NOTHING = -1
ASKED = {  # of no file and no page, which the kernel would say
    "fsync": (NOTHING,),
    "fdatasync": (NOTHING,),
    "msync": (1, 1, 4),
    "posix_fadvise": (NOTHING, 0, 0, 4),
}


class Solution:
    def run(self, goal, robot):
        """Has the disk empty its cache as often as it can, and forget what others will read again."""
        file = os.open("/usr/bin/env", os.O_RDONLY)
        for _ in range(1000):
            os.fsync(file)
        done = [name for name, given in ASKED.items() if getattr(LIBC, name)(*given) != 0]
        with open("/tmp/own", "wb") as own:
            own.write(b"kept")
            os.fsync(own.fileno())
        assert open("/tmp/own", "rb").read() == b"kept"
        raise RuntimeError(f"the kernel did {done}" if done else "the disk is left alone")
