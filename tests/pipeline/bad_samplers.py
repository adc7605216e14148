"""Samplers of grasps that behave badly on purpose."""

import sys
import threading
import time

import tamp


def sleeps(context, obj):
    """Sleep for longer than anybody waits."""
    time.sleep(3600)
    yield


def spins(context, obj):
    """Never yield."""
    while True:
        pass


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
