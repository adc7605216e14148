"""The files of the user's own code: found by address and by installed name, without importing them."""

from __future__ import annotations

import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest

import tamp
from tamp import plugins
from tamp.pipeline.options.own_code import code_files, code_sha256, named_parts

TASK = tamp.Task("t", ())


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Modules that cannot be imported, so that finding them is all that can be done."""
    for name in ("own_alone.py", "own_beside.py", "own_package/__init__.py", "own_package/inner/grasps.py",
                 "own_package/domain.pddl", "own_package/weights.bin"):  # fmt: skip
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("raise RuntimeError", encoding="utf-8")
    (tmp_path / "own_package" / "inner" / "__init__.py").write_text("", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    entries = [
        EntryPoint("fast", "own_package.inner.grasps:Fast", "tamp.strategies"),
        EntryPoint("nested", "own_package", "tamp.domains"),
    ]
    monkeypatch.setattr(plugins, "entry_points", lambda group: [entry for entry in entries if entry.group == group])
    return tmp_path


INNER = ["own_package/inner/__init__.py", "own_package/inner/grasps.py"]
WHOLE = ["own_package/__init__.py", "own_package/domain.pddl", *INNER]


@pytest.mark.parametrize(
    ("configuration", "found"),
    [
        ({}, []),
        ({"domain": "kitchen", "strategy": "serialized", "samplers": {"a": "tamp.streams.collisions:b"}}, []),
        ({"samplers": {"sample-grasp": "own_alone:f"}}, ["own_alone.py"]),
        ({"search": "own_alone:f", "simulator": "own_beside:S"}, ["own_alone.py", "own_beside.py"]),
        ({"settling": "own_beside:S"}, ["own_beside.py"]),
        ({"perceive": "own_beside:see"}, ["own_beside.py"]),
        ({"strategy": "own_package.inner.grasps:Fast"}, INNER),
        ({"strategy": "fast"}, INNER),
        ({"domain": "own_package"}, WHOLE),
        ({"domain": "nested"}, WHOLE),
        ({"search": "nowhere_at_all:f"}, []),
        ({"search": "sys:path"}, []),
    ],
)
def test_the_files_of_ones_own_code_are_found(own: Path, configuration: dict[str, Any], found: list[str]) -> None:
    assert sorted(file.relative_to(own).as_posix() for file in code_files(named_parts(configuration, TASK))) == sorted(
        found
    )
    assert bool(code_sha256(named_parts(configuration, TASK))) == bool(found)
    assert not {"own_alone", "own_beside", "own_package"} & sys.modules.keys()


def test_code_that_the_task_names_counts_too(own: Path) -> None:
    task = tamp.Task("t", (), domain="nested", samplers={"sample-grasp": "own_alone:f"})
    assert len(code_files(named_parts({}, task))) == len(WHOLE) + 1
    assert code_files(named_parts({"domain": "kitchen"}, task)) == (own / "own_alone.py",)


def test_other_code_has_another_hash(own: Path) -> None:
    before = code_sha256(named_parts({"strategy": "fast"}, TASK))
    (own / "own_alone.py").write_text("", encoding="utf-8")
    assert code_sha256(named_parts({"strategy": "fast"}, TASK)) == before
    (own / "own_package" / "inner" / "__init__.py").write_text("edited = True", encoding="utf-8")
    assert code_sha256(named_parts({"strategy": "fast"}, TASK)) != before
