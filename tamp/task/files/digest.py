"""The content of a task as one number: of its file and its meshes, wherever they lie."""

from __future__ import annotations

import hashlib
from collections.abc import MutableMapping
from pathlib import Path

from tamp.task.model import Mesh, Task


def task_sha256(task: Task, known: MutableMapping[Path, str] | None = None) -> str:
    """SHA-256 over the task's file and its objects' meshes, in order; empty where the task came from no file.

    Args:
        task: the task.
        known: digests of files that several tasks share; filled on the way.
    """
    if task.path is None or not task.path.is_file():
        return ""
    known = {} if known is None else known
    whole = hashlib.sha256(task.path.read_bytes())
    for path in (o.shape.path for o in task.objects if isinstance(o.shape, Mesh)):
        if path not in known:
            known[path] = hashlib.sha256(path.read_bytes()).hexdigest()
        whole.update(known[path].encode())
    return whole.hexdigest()
