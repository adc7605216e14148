"""What `tamp contest run -o DIR` keeps: each run as it ends, so that a command that was killed can go on."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from tamp.batch.identity import Making
from tamp.batch.journal import Journal
from tamp.cli.output import write_text
from tamp.contest.rules import scene_of
from tamp.errors import TampError
from tamp.results import Result
from tamp.task.files.digest import task_sha256
from tamp.versions import versions

if TYPE_CHECKING:
    from tamp.contest.evaluation.trial import Trial
    from tamp.contest.rules import Rules
    from tamp.task import Task

RUNS, RESULTS = "runs.jsonl", "results.json"


class Runs:
    """The runs of a solution in a folder; a context manager.

    Args:
        folder: made where it is absent.
        solution: its file or folder.
        tasks, rules: under which it runs.
        isolation: name of the sandbox.
        resume: keep what was made of the same solution, task, rules and versions.
        overwrite: begin anew.

    Raises:
        TampError: where the folder has runs and neither is said, or cannot be written.
    """

    def __init__(
        self,
        folder: Path,
        solution: Path,
        tasks: Sequence[Task],
        rules: Rules,
        isolation: str,
        *,
        resume: bool,
        overwrite: bool,
    ) -> None:
        self._folder = folder
        held = [file for file in (folder / RESULTS, folder / RUNS) if file.is_file() and file.stat().st_size]
        if held and not (resume or overwrite):
            raise TampError(
                f"{held[0]} has results already: --resume runs what is missing, --overwrite replaces them; "
                "nothing was touched"
            )
        code, options, libraries = _sha256(solution), _deciding(rules, isolation), versions()
        self._makings = {task.name: Making(options, task_sha256(task), libraries, code) for task in tasks}
        self._journal = Journal(folder / RUNS)
        self.known = tuple(r for r in self._journal.results() if resume and self._is_made_so(r))
        self._journal.keep(self.known)
        (folder / RESULTS).unlink(missing_ok=True)  # until all runs are done, there are none

    def __enter__(self) -> Runs:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._journal.__exit__(kind, error, trace)

    def add(self, trial: Trial) -> None:
        """Write a run, and what it printed."""
        result, made = trial.result, self._makings[trial.result.task]
        name = re.sub(r"[^A-Za-z0-9_.-]+", "-", f"{result.task}-{result.simulator}-{result.seed}")
        write_text(self._folder / f"{name}.log", trial.log.decode("utf-8", errors="replace"))
        self._journal.append(
            replace(
                result,
                configuration=made.configuration,
                task_sha256=made.task_sha256,
                code_sha256=made.code_sha256,
                versions=made.versions,
            )
        )

    def _is_made_so(self, result: Result) -> bool:
        making = self._makings.get(result.task)
        return making is not None and not making.differences(result)


def _deciding(rules: Rules, isolation: str) -> Mapping[str, Any]:
    """What of the rules decides a run; which ones there are, and what counts of them, does not."""
    return {**scene_of(rules), "libraries": list(rules.libraries), "isolation": isolation, **asdict(rules.limits)}


def _sha256(path: Path) -> str:
    """Of a file, or of all files in a folder and their names, but for what Python compiles of them.

    Raises:
        TampError: where one cannot be read.
    """
    whole = hashlib.sha256()
    try:
        files = sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]
        for file in files:
            if "__pycache__" not in file.parts:
                name = str(file.relative_to(path)).encode("utf-8", errors="surrogateescape")
                whole.update(name + b"\0" + hashlib.sha256(file.read_bytes()).digest())
    except OSError as error:
        raise TampError(f"{error.filename}: cannot be read: {error.strerror}") from None
    return whole.hexdigest()
