"""The first program in a sandbox: takes its limits on, loads the solution, runs it, and says how that ended."""

from __future__ import annotations

import ctypes
import faulthandler
import importlib
import inspect
import io
import json
import os
import resource
import socket
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from tamp.contest.adapters.ocrtoc2024 import HOME, Agent2024, offer
from tamp.contest.api import walls
from tamp.contest.api.client import Connection, connect
from tamp.contest.api.schema import VERSION
from tamp.contest.api.wire import FROM_SERVER, Channel, Disconnected

PR_SET_SECCOMP, SECCOMP_MODE_FILTER, PR_SET_NO_NEW_PRIVS = 22, 2, 38


class Instruction(ctypes.Structure):
    """struct sock_filter."""

    _fields_ = [("code", ctypes.c_uint16), ("true", ctypes.c_uint8), ("false", ctypes.c_uint8), ("k", ctypes.c_uint32)]


class Program(ctypes.Structure):
    """struct sock_fprog."""

    _fields_ = [("length", ctypes.c_uint16), ("first", ctypes.POINTER(Instruction))]


def main(arguments: str) -> int:
    """Run a solution; the exit status is 0 where it returned.

    Args:
        arguments: JSON: descriptor (of the socket), run (false where the solution is only to be made), solution and
            models (folders), module, libraries (distributions that are offered), limits (rlimit -> value), filter (of
            system calls; empty for none).
    """
    given = json.loads(arguments)
    for name, value in given["limits"].items():
        limit(getattr(resource, name), value)
    if given["filter"]:
        take_on(given["filter"])
        walls.hide_refused()
    os.environ["PYTHONPATH"] = os.pathsep.join((given["solution"], os.environ["PYTHONPATH"]))
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # what is printed before a run is stopped is read, and in its order
            stream.reconfigure(line_buffering=True)
    faulthandler.enable()  # where a library crashes, its owner reads which
    connection = Connection(Channel(socket.socket(fileno=given["descriptor"]), FROM_SERVER))
    if given["run"]:
        goal, robot = connect(connection, Path(given["models"]))
    else:
        connection.tell("hello", version=VERSION)
    try:
        solution = load(Path(given["solution"]), given["module"])()
        _require_arguments(solution.run)
        if given["run"]:
            solution.run(goal, robot)
    except BaseException as error:  # whatever it is, its owner wants to read it, and the server to know
        with suppress(Exception):  # it may have closed where that is printed
            traceback.print_exc()
        _tell(connection, "raised", error=_said(error, Path(given["solution"]), given["libraries"]))
        return 1
    _tell(connection, "finished")
    return 0


def limit(kind: int, most: int) -> None:
    """Have the kernel limit this process and its children, to what the machine allows where that is less."""
    highest = resource.getrlimit(kind)[1]
    most = most if highest == resource.RLIM_INFINITY else min(most, highest)
    resource.setrlimit(kind, (most, most))


def take_on(instructions: Sequence[Sequence[int]]) -> None:
    """Have the kernel put this process's system calls, and those of its children, through a filter from now on.

    Args:
        instructions: as `tamp.contest.sandbox.seccomp` writes them.

    Raises:
        OSError: where the kernel refuses it.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    program = Program(len(instructions), (Instruction * len(instructions))(*(Instruction(*i) for i in instructions)))
    if libc.prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) or libc.prctl(
        PR_SET_SECCOMP, SECCOMP_MODE_FILTER, ctypes.byref(program)
    ):
        raise OSError(ctypes.get_errno(), "the kernel takes no filter of system calls")


def load(folder: Path, module: str) -> Any:
    """The class `Solution` of a module in a folder; an agent as OCRTOC 2024 has it is made into one."""
    sys.path.insert(0, str(folder))
    if not (folder / HOME.partition(".")[0]).exists():  # a package may bring 2024's own
        offer()
    loaded = importlib.import_module(module)
    if folder not in Path(getattr(loaded, "__file__", None) or "/").parents:
        raise TypeError(f"another module is called {module!r}; call it 'solution'")
    found = getattr(loaded, "Solution", None)
    run = getattr(found, "run", None)
    if inspect.iscoroutinefunction(run) or inspect.isgeneratorfunction(run) or inspect.isasyncgenfunction(run):
        raise TypeError("Solution.run is a coroutine or a generator, of which nothing would run; make it a function")
    if isinstance(found, type) and callable(run):
        return found
    agent = found or getattr(loaded, "MyAgent", None)
    if isinstance(agent, type) and callable(getattr(agent, "draw_action", None)):
        return Agent2024.of(agent)
    place = "; import it in the package's __init__.py" if hasattr(loaded, "__path__") else ""
    raise TypeError(
        f"the module {module!r} has no class Solution with run(self, goal, robot), nor MyAgent with "
        f"draw_action(self, observation){place}"
    )


def _require_arguments(run: Callable[..., object]) -> None:
    try:
        inspect.signature(run).bind("goal", "robot")
    except ValueError:  # it does not tell what it takes
        return
    except TypeError as error:
        raise TypeError(f"Solution.run is called with goal and robot: {error}") from None


def _said(error: BaseException, folder: Path, libraries: Sequence[str]) -> str:
    """An exception in a line, whatever its own words do; of a library that is not there, what there is."""
    try:
        hint = _missing(error, folder, libraries) or _beside(error, folder) or walls.met(error)
        words = ": ".join(filter(None, (type(error).__name__, str(error))))[:1000] + hint
        return words[:1900].encode("utf-8", "replace").decode()
    except BaseException:  # its words may be anything, an exit too
        return type(error).__name__


def _missing(error: BaseException, folder: Path, libraries: Sequence[str]) -> str:
    """What may be imported, and how, where a solution asked for what is not there; else nothing."""
    if isinstance(error, ImportError) and "no known parent package" in str(error):
        return (
            "; a module beside solution.py is imported by its name alone: 'import helpers', not 'from . import helpers'"
        )
    if not isinstance(error, ModuleNotFoundError) or type(error.name) is not str:
        return ""
    top = error.name.partition(".")[0]
    if any((folder / name).exists() for name in (top, f"{top}.py")):
        return ""  # a module of its own
    return (
        f"; a solution may import Python's own library, {', '.join(('numpy', *libraries))} and what its package brings"
        ": put the library into the .zip, beside the solution, or have it offered by 'libraries' in contest.yaml "
        "(--library NAME of tamp contest run)"
    )


def _beside(error: BaseException, folder: Path) -> str:
    """Where a file is that a solution looked for in the working folder, though its package has it; else nothing."""
    name = error.filename if isinstance(error, FileNotFoundError) else None
    if type(name) is not str or not (folder / name).exists() or Path(name).is_absolute():
        return ""
    return (
        f"; the working folder is /tmp, and a package's files are beside its module: Path(__file__).parent / {name!r}"
    )


def _tell(connection: Connection, kind: str, **fields: str) -> None:
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):
            stream.flush()
    try:
        connection.tell(kind, **fields)
    except Disconnected:
        sys.exit(1)  # the server has ended the run already, and knows why
