"""`tamp solve --replay RUN`: run again what a run's manifest records, and hold the two plans against each other."""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tamp.cli.output import to_stdout, write_json
from tamp.cli.status import SOLVED, UNSOLVED
from tamp.errors import TampError
from tamp.task.files.regular_file import read_regular

HEARD = ("replay", "trust_task_code", "json", "verbose", "quiet")
"""The options that --replay does something with."""


def replay(options: argparse.Namespace) -> int:
    """Solve the run's task once more; exit status 0 where the plan is the same to the last bit.

    Raises:
        TampError: where the folder holds no run, an input has changed since, or other options are given.
    """
    _refuse_other_options(options)
    from tamp.pipeline.options.trust import HOW, code_of
    from tamp.pipeline.solving.solve import solve
    from tamp.task.files.load import load_task
    from tamp.task.robots import with_robot
    from tamp.versions import versions

    manifest, out = options.replay / "manifest.json", sys.stderr if to_stdout(options) else options.out
    recorded = _manifest(manifest)
    # Whom the run's owner trusted says nothing of whom this user trusts.
    configuration = {**recorded["configuration"], "trust_task_code": options.trust_task_code}
    if (code := code_of(configuration)) and not options.trust_task_code:
        raise TampError(f"{manifest}: the run used {', '.join(code)}; {HOW}")
    task = load_task(recorded["task_path"], allow_outside=configuration.pop("allow_outside"))
    task = with_robot(task, configuration.pop("robot", None))
    for name, version in versions().items():
        if recorded["versions"].get(name) != version:
            print(f"note: {name} is {version}; the run had {recorded['versions'].get(name, 'none')}", file=out)
    result = solve(task, **configuration)
    same = result.plan_sha256 == recorded["plan_sha256"]
    told = "the same plan" if same else "another plan"
    print(f"{task.name}, seed {result.seed}: {result.status}; {told}", file=out)
    write_json(options, [result.as_dict()])
    return SOLVED if same else UNSOLVED


def _refuse_other_options(options: argparse.Namespace) -> None:
    """Refuse what the run's record says itself: nothing that is given shall go unheard."""
    unsaid = vars(options.parser.parse_args(["solve"]))
    given = [name for name in unsaid if name not in HEARD and getattr(options, name) != unsaid[name]]
    if given:
        said = ", ".join("TASK.yaml" if name == "tasks" else f"--{name.replace('_', '-')}" for name in given)
        heard = ", ".join(f"--{name.replace('_', '-')}" for name in HEARD[1:])
        raise TampError(f"--replay runs what RUN records and cannot be given with {said}; it takes {heard} alone")


def _manifest(path: Path) -> Mapping[str, Any]:
    try:
        data = json.loads(read_regular(path))
    except OSError as error:
        raise TampError(f"{path}: cannot be read: {error.strerror}; give one run's folder, OUT/TASK-SEED") from None
    except (ValueError, RecursionError) as error:
        raise TampError(f"{path}: not the manifest of a run: {error}") from None
    if not isinstance(data, dict) or data.get("format") != "tamp-manifest" or data.get("version") != 1:
        raise TampError(f"{path}: not a manifest of version 1")
    if not data.get("task_path"):
        raise TampError(f"{path}: the run's task came from no file and cannot be run again")
    for name, digest in data["inputs"].items():
        file = Path(name)
        if not file.is_file() or hashlib.sha256(file.read_bytes()).hexdigest() != digest:
            raise TampError(f"{path}: {file} has changed since the run, or is gone")
    return data
