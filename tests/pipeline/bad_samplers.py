"""Samplers of grasps that behave badly on purpose."""

import os
import sys
import threading
import time

import numpy as np

import tamp
from tamp.streams.grasping.sampler import sample_grasp


def sleeps(context, obj):
    """Sleep for longer than anybody waits."""
    time.sleep(3600)
    yield


def spins(context, obj):
    """Never yield."""
    while True:
        pass


def spins_in_c(context, obj):
    """Never come back from C, which lets no other thread run meanwhile."""
    sum(range(10**15))
    yield


def swallows(context, obj):
    """Spin, and let no exception through."""
    end = time.monotonic() + 3600
    while time.monotonic() < end:
        try:
            time.sleep(0.01)
        except BaseException:  # noqa: PERF203  as bad as it can be
            continue
    yield


def starts_a_thread(context, obj):
    """Leave a thread behind that nobody ends, and wait for it."""
    thread = threading.Thread(target=time.sleep, args=(3600,))
    thread.start()
    thread.join()
    yield


def raises(context, obj):
    """Raise in the middle."""
    raise ValueError(f"no idea how to grasp {obj}")
    yield


def refuses(context, obj):
    """Raise what the framework itself raises."""
    raise tamp.TaskError("not this one")
    yield


def exits(context, obj):
    """Try to end the program as if all were well."""
    sys.exit(0)
    yield


def returns_a_number(context, obj):
    """Be no generator."""
    return 3


def yields_words(context, obj):
    """Yield what is no grasp."""
    yield "from above"


def yields_a_matrix(context, obj):
    """Yield what is shown in several lines."""
    yield np.eye(4)


def yields_nothing(context, obj):
    """Yield None for ever."""
    while True:
        yield None


def prints(context, obj):
    """Print, by Python and below it."""
    import os

    print("a sampler's print")
    os.write(1, b"a native print\n")
    context.fail("too busy printing")
    yield from ()


def interrupts(context, obj):
    """Say that the user wants to end the program."""
    raise KeyboardInterrupt
    yield


def closes_streams(context, obj):
    """Close what results are printed to."""
    sys.stdout.close()
    sys.stderr.close()
    yield from sample_grasp(context, obj)


def ends(context, obj):
    """End the process from below, as if all were well."""
    os._exit(0)
    yield


def forks(context, obj):
    """Go on in two processes."""
    os.fork()
    yield from sample_grasp(context, obj)
