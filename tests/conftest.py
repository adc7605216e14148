"""Property tests draw the same examples at every run, so that a red one repeats; with EXPLORE set they draw others.

No example has a deadline: on a busy machine that would test the machine.
"""

import gc
import os
import signal

import pytest
from hypothesis import settings

settings.register_profile("same", derandomize=True, deadline=None)
settings.register_profile("exploring", deadline=None)
settings.load_profile("exploring" if os.environ.get("EXPLORE") else "same")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Thousands of tests and all that they import stay to the end, and need not be gone through for garbage."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture(autouse=True, scope="session")
def interrupts():
    """A shell ignores Ctrl-C in what it starts in the background, and so would all tests of it there."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
