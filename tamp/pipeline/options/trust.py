"""A task file from a stranger runs no code: what it names to be imported is used only where the user says so."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tamp.errors import TaskError
from tamp.task import Task
from tamp.task.files.yaml_document import read_document

HOW = "code is run only where you trust it: --trust-task-code, or trust_task_code=True in Python"

BY_ADDRESS = ("strategy", "search", "simulator", "settling", "perceive")
"""Options that name code where they have the form of an address, besides samplers and domains."""


def code_of(configuration: Mapping[str, Any]) -> tuple[str, ...]:
    """The code that the record of a run names, which is a stranger's as a task's file may be."""
    named = [*(configuration.get("samplers") or {}).values(), _outside(configuration.get("domain") or Task.domain)]
    named += [said for field in BY_ADDRESS if ":" in (said := configuration.get(field) or "")]
    return tuple(text for text in named if text)


def refuse_code(task: Task, domain: str | None = None, *, trusted: bool) -> None:
    """Refuse a task whose file names code to be run, unless the user trusts it; a task built in code may name any.

    Args:
        task: the task.
        domain: what the user names in place of the task's own.
        trusted: whether the user trusts the task.

    Raises:
        TaskError: names file, line, and the code.
    """
    if trusted or task.path is None:
        return
    asked = {"samplers": ", ".join(sorted(task.samplers.values())), "domain": "" if domain else _outside(task.domain)}
    for field in BY_ADDRESS:
        said = getattr(task, field, None) or ""
        asked[field] = said if ":" in said else ""
    for field, code in asked.items():
        if code:
            where = read_document(task.path).where((field,)) if task.path.is_file() else str(task.path)
            install = ", which is not installed, as TAMP_DOMAINS or an entry point does it" * (field == "domain")
            raise TaskError(f"{where}: the task asks for {code}{install}; {HOW}")


def _outside(domain: str) -> str:
    """The domain where it is not an installed one, else nothing."""
    if domain == Task.domain:
        return ""
    from tamp.domains.catalog import domain_names

    return "" if domain in domain_names() else domain
