"""Work functions that behave badly on purpose."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from tamp.clock import ended_at
from tamp.errors import TampError
from tamp.results import Result


def pause_without_python() -> None:
    """Be in native code, where no signal of Python's gets through, for a minute."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM})
    time.sleep(60)


def work(name: str, path: str, seed: int, folder: str | None = None, **options: Any) -> dict[str, Any]:
    """Do what the task's name says."""
    ran = options.get("ran")
    if ran is not None:
        with Path(ran).open("a", encoding="utf-8") as file:
            file.write(f"{name}:{seed}\n")
    kind = name.partition("_")[0]
    if kind == "crash":
        os.abort()
    elif kind == "exit":
        sys.exit(3)
    elif kind == "raise":
        raise ValueError("a bug\nin two lines")
    elif kind == "refuse":
        raise TampError("no such simulator")
    elif kind == "full":
        raise OSError(errno.ENOSPC, "No space left on device", "plan-0.json")
    elif kind == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    elif kind == "hang":
        child = subprocess.Popen(["sleep", "600"])
        Path(options["pids"]).write_text(f"{os.getpid()} {child.pid}", encoding="utf-8")
        time.sleep(600)
    elif kind == "eat":
        memory = []
        while True:
            memory.append(b"x" * 50_000_000)
    elif kind == "late":
        with ended_at(time.monotonic() + 0.2), suppress(BaseException):
            pause_without_python()
    elif kind == "orphan":
        once = Path(options["once"])
        if not once.exists():
            once.write_text("", encoding="utf-8")
            os.kill(os.getppid(), signal.SIGKILL)
            time.sleep(60)
    elif kind == "slow":
        time.sleep(options.get("sleep", 0.3))
    return Result(task=name, seed=seed, status="solved", task_path=path).as_dict()
