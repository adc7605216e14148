"""Final poses from any source: {"name": {"xyz": [x, y, z], "quat": [x, y, z, w]}}, in JSON or YAML; null is lost."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tamp.errors import TaskError
from tamp.task.files.yaml_document import Document, read_document
from tamp.task.pose import Pose


def load_poses(path: Path) -> dict[str, Pose | None]:
    """Read object -> pose (world frame); metres; orientation as `quat` or `rpy` [rad], none where both are absent.

    Raises:
        TaskError: names file, line and field, and what would be valid.
    """
    document = read_document(path)
    if not isinstance(document.value, Mapping):
        raise TaskError(f"{path}: expected a mapping of object names to poses")
    return {name: _pose(document, name, value) for name, value in document.value.items()}


def _pose(document: Document, name: str, value: Any) -> Pose | None:
    if value is None:
        return None
    where = document.where((name,))
    fields = set(value) if isinstance(value, Mapping) else set()
    if "xyz" not in fields or not fields <= {"xyz", "quat", "rpy"} or fields >= {"quat", "rpy"}:
        raise TaskError(f"{where}: expected {{xyz: [x, y, z]}} with quat: [x, y, z, w] or rpy: [r, p, y]")
    rows = {key: _numbers(document, name, key, row, 4 if key == "quat" else 3) for key, row in value.items()}
    try:
        if "rpy" in rows:
            return Pose.from_rpy(rows["xyz"], rows["rpy"])
        return Pose(rows["xyz"], rows.get("quat", (0.0, 0.0, 0.0, 1.0)))
    except ValueError as error:
        raise TaskError(f"{where}: {error}") from None


def _numbers(document: Document, name: str, key: str, row: Any, count: int) -> Any:
    if not isinstance(row, tuple) or len(row) != count or not all(type(v) in (int, float) for v in row):
        raise TaskError(f"{document.where((name, key))}: expected {count} numbers")
    return row
