"""Property tests draw the same examples at every run of CI, so that a red one repeats; elsewhere they explore.

No example has a deadline: on a busy machine that would test the machine.
"""

import os

from hypothesis import settings

settings.register_profile("ci", derandomize=True, deadline=None)
settings.register_profile("exploring", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "exploring")
