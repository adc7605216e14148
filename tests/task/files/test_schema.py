"""The schema in the docs is the schema in the code."""

from __future__ import annotations

import json
from pathlib import Path

from tamp.task.files.schema import TaskModel

DOCS = Path(__file__).parents[3] / "docs" / "reference" / "task.schema.json"


def test_the_documented_schema_is_current() -> None:
    assert json.loads(DOCS.read_text(encoding="utf-8")) == TaskModel.model_json_schema()
