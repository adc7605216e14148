"""raised: nothing could be written"""

import os


class Solution:
    def run(self, goal, robot):
        written = []
        for folder in (
            "/",
            "/usr",
            "/etc",
            "/site",
            "/solution",
            "/models",
            "/proc/sys/kernel",
            "/dev",
            "/usr/bin",
            "/var/tmp",
        ):
            try:
                with open(os.path.join(folder, "hostile"), "w") as file:
                    file.write("was here")
                written.append(folder)
            except OSError:
                pass
        try:
            with open("/proc/sys/kernel/core_pattern", "w") as file:
                file.write("|/tmp/hostile")
            written.append("core_pattern")
        except OSError:
            pass
        raise RuntimeError(f"wrote to {written}" if written else "nothing could be written")
