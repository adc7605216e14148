"""Property tests draw the same examples at every run, so that a red one repeats; with EXPLORE set they draw others.

No example has a deadline: on a busy machine that would test the machine.
"""

import os

from hypothesis import settings

settings.register_profile("same", derandomize=True, deadline=None)
settings.register_profile("exploring", deadline=None)
settings.load_profile("exploring" if os.environ.get("EXPLORE") else "same")
