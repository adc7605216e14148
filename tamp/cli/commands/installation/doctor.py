"""`tamp doctor`: versions, binaries, extras, and a task small enough to show that all parts work together."""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Callable, Iterator
from importlib.metadata import PackageNotFoundError, metadata, version
from typing import TYPE_CHECKING, Any

from tamp.cli.options import add_json, command
from tamp.cli.output import to_stdout, write_json
from tamp.cli.status import SOLVED, UNSOLVED
from tamp.versions import DISTRIBUTION, how_to_install, needs, versions

if TYPE_CHECKING:
    from typing import TextIO

    from tamp.cli.options import Commands


def add(commands: Commands) -> None:
    """`doctor`."""
    add_json(command(commands, "doctor", doctor, "show versions, binaries and extras, and test the installation"))


def doctor(options: argparse.Namespace) -> int:
    """Print what is installed and what works; exit status 1 where something that is required does not."""
    from tamp.execution.simulators import SIMULATORS, installed

    checks: list[tuple[str, Callable[[], str]]] = [
        ("Fast Downward", _fast_downward), ("robots", _robots), ("simulators", _simulators),
        ("one block, from A to B", _one_block),
    ]  # fmt: skip
    tested = [_tested(title, check) for title, check in checks]
    extras = dict(_missing_of_extras())
    optional = {entry.library for entry in SIMULATORS.values()} if installed() else set()  # one is enough
    broken = [name for name, found in versions().items() if found == "absent" and name not in optional]
    broken += [test["name"] for test in tested if not test["works"]]
    if not to_stdout(options):
        _print(tested, extras, broken, options.out)
    write_json(options, {"versions": versions(), "tests": tested, "extras_missing": extras, "broken": broken})
    return UNSOLVED if broken else SOLVED


def _print(tested: list[dict[str, Any]], extras: dict[str, list[str]], broken: list[str], out: TextIO) -> None:
    for name, found in versions().items():
        print(f"{name:18s} {found}", file=out)
    for test in tested:
        print(f"{test['name']:24s} {test['said']}  ({test['seconds']:.1f} s)", file=out)
    for extra, missing in extras.items():
        told = f"needs {', '.join(missing)}: {how_to_install(extra)}" if missing else "installed"
        print(f"extra {extra:18s} {told}", file=out)
    print("all is well" if not broken else f"broken or absent: {', '.join(broken)}", file=out)


def _tested(title: str, check: Callable[[], str]) -> dict[str, Any]:
    began = time.monotonic()
    try:
        said, works = check(), True
    except Exception as error:  # whatever is broken here is what the user came to be told
        said, works = f"BROKEN: {type(error).__name__}: {error}", False
    return {"name": title, "works": works, "said": said, "seconds": time.monotonic() - began}


def _missing_of_extras() -> Iterator[tuple[str, list[str]]]:
    """Each extra for users and what of it is not installed; those for developers are left out."""
    for extra in sorted(metadata(DISTRIBUTION).get_all("Provides-Extra") or ()):
        if extra not in ("dev", "test", "docs"):
            names = [re.split(r"[^A-Za-z0-9_.-]", what, maxsplit=1)[0] for what in needs(extra)]
            yield extra, [name for name in names if not _installed(name)]


def _installed(name: str) -> bool:
    try:
        version(name)
    except PackageNotFoundError:
        return False
    return True


def _fast_downward() -> str:
    from tamp.planning.search.fast_downward import binary

    return str(binary())


def _robots() -> str:
    """Each robot, and why it cannot be used where it cannot: one that can is enough."""
    reasons = _why_not()
    if all(reasons.values()):
        told = "; ".join(f"{name}: {reason}" for name, reason in reasons.items())
        raise RuntimeError(f"none can be used: {told}; another arm: {how_to_install('ur5e')}")
    return ", ".join(f"{name} (cannot be used: {reason})" if reason else name for name, reason in reasons.items())


def _why_not() -> dict[str, str]:
    """Why a robot cannot be used, for each by name; empty where it can. The default one comes first."""
    from tamp.errors import RobotError
    from tamp.task import DEFAULT_ROBOT, load_robot, robot_names
    from tamp.world.robot.model import robot_model

    def reason(name: str) -> str:
        try:
            robot_model(load_robot(name))
        except RobotError as error:  # the file that says so is no news here
            return str(error).rpartition("urdf: ")[2]
        return ""

    return {name: reason(name) for name in sorted(robot_names(), key=lambda name: name != DEFAULT_ROBOT)}


def _simulators() -> str:
    from tamp.execution.simulators import SIMULATORS, make_simulator

    told = []
    for name, entry in SIMULATORS.items():
        if entry.installed:
            with make_simulator(name, ()) as world:
                world.step()
        told.append(name if entry.installed else f"{name} (not installed)")
    return ", ".join(told)


def _one_block() -> str:
    from tamp.pipeline.solving.solve import solve
    from tamp.task import At, Box, Object, Pose, Task

    robot = next((name for name, reason in _why_not().items() if not reason), None)
    if robot is None:
        raise RuntimeError("there is no robot to do it")
    block = Object("block", Box((0.05, 0.05, 0.08)), Pose((0.1, 0.2, 0.04)), At(Pose((0.1, -0.2, 0.04))))
    result = solve(Task("doctor", (block,), robot=robot), timeout=30.0)
    if not result.solved:
        raise RuntimeError(f"{result.status}: {result.message}")
    error = 1000 * (result.ede_m or 0.0)
    return f"solved by {robot} with {result.n_actions} actions, error {error:.1f} mm"
