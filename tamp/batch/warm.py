"""What the server that workers are forked from imports, and becomes: all that runs have in common is loaded and made.

A worker begins at its task then, not at its imports. It is a copy of a process that has run nothing: what a run
computes does not depend on those before it.
"""

from __future__ import annotations

from contextlib import suppress

import tamp.pipeline.solving.run
import tamp.pipeline.solving.solve
import tamp.task.files.load  # noqa: F401
from tamp.batch.robots import told
from tamp.errors import TampError
from tamp.pipeline.loading import preload
from tamp.versions import versions

for nothing in told():
    with suppress(TampError):  # the run that needs what cannot be had says so
        preload(nothing)
versions()
