"""The inside of a worker process: one job, then the end. What it sends back is JSON text, never a pickle."""

from __future__ import annotations

import errno
import gc
import importlib
import json
import logging
import os
import select
import signal
import sys
import traceback
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from typing import Any

from tamp.clock import watched
from tamp.errors import TampError
from tamp.parent import end_with_parent

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def run_job(connection: Connection, work: str, arguments: Mapping[str, Any], level: int) -> None:
    """Call `work` ("package.module:function") with `arguments` and send back what it returns, or how it failed.

    Args:
        connection: where messages go: any number of {"until": time.monotonic() [s] or null}, by when what the job is
            at must have ended, and one {"value": ...}, {"error": one line}, or {"full": one line} for a full disk.
        work: a function of JSON-like keyword arguments that returns a JSON-like mapping.
        arguments: its keyword arguments.
        level: from which on what is logged is said, on standard error.
    """
    _detach()
    logging.basicConfig(stream=sys.stderr, format="tamp: %(message)s")
    logging.getLogger("tamp").setLevel(level)
    if _unheard(connection):
        return
    gc.freeze()  # what was loaded before is no garbage: no collection need look at it
    try:
        module, _, function = work.partition(":")
        call: Callable[..., Any] = getattr(importlib.import_module(module), function)
        with watched(lambda until: _say(connection, {"until": until})):
            message = {"value": call(**arguments)}
    except MemoryError:
        message = {"error": "out of memory"}
    except Exception as error:  # a job's bug costs that job alone; the traceback goes where the user can see it
        if isinstance(error, OSError) and error.errno in FULL:
            message = {"full": f"{error.filename or arguments.get('folder')}: {error.strerror}"}
        elif isinstance(error, TampError) and level > logging.INFO:
            message = {"error": " ".join(str(error).split())}
        else:
            traceback.print_exc()
            message = {"error": " ".join(f"{type(error).__name__}: {error}".split())}
    _say(connection, message)
    connection.close()
    for stream in (sys.stdout, sys.stderr):
        if not stream.closed:  # a sampler may have closed it
            stream.flush()


def _say(connection: Connection, message: Mapping[str, Any]) -> None:
    """Send a message; where nobody is left to hear it, the batch has ended, and so does this process."""
    try:
        connection.send_bytes(json.dumps(message).encode())
    except BrokenPipeError:
        os._exit(1)


def _unheard(connection: Connection) -> bool:
    """Whether nobody is left at the other end: the batch was ended while this process began."""
    ends = select.poll()
    ends.register(connection.fileno(), 0)  # what is reported all the same is an error: a pipe without a reader
    return bool(ends.poll(0))


def _detach() -> None:
    """Be the head of a process group of one's own, leave standard output alone, and end with the parent."""
    os.setsid()
    os.dup2(2, 1)  # it belongs to whoever asked for results; samplers and native libraries print where they like
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
