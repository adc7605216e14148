"""What a result was made of, held against what is asked for now: only what was made the same way is kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tamp.results import Result


@dataclass(frozen=True)
class Making:
    """What decides a result besides its task's name and its seed.

    Attributes:
        configuration: the options of the work function, JSON-like.
        task_sha256: of the task's file and meshes.
        versions: of the program and its libraries.
        code_sha256: of the user's own code that takes part; empty where there is none.
    """

    configuration: Mapping[str, Any]
    task_sha256: str
    versions: Mapping[str, str]
    code_sha256: str = ""

    def differences(self, result: Result) -> Sequence[str]:
        """In what a result was made otherwise; none where it would be made the same way."""
        found = [] if result.task_sha256 == self.task_sha256 else ["the task"]
        found += [] if result.code_sha256 == self.code_sha256 else ["code of your own"]
        options = {**self.configuration, **result.configuration}
        found += [name for name in options if _of(result.configuration, name) != _of(self.configuration, name)]
        libraries = {**self.versions, **result.versions}
        return [*found, *(name for name in libraries if result.versions.get(name) != self.versions.get(name))]


def _of(options: Mapping[str, Any], name: str) -> Any:
    """An option's value; what is empty is as good as not given."""
    return options.get(name) or None
