"""Property tests draw the same examples at every run of CI, so that a red one repeats; elsewhere they explore."""

import os

from hypothesis import settings

settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")
