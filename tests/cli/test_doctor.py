"""`tamp doctor`: what is there works, and what lacks is named; one robot is enough."""

from __future__ import annotations

from typing import Any

import pytest

import tamp.task
from tamp.cli import main
from tamp.errors import RobotError


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A function after whose call robots of some names cannot be loaded, as where the package of their meshes lacks."""
    load = tamp.task.load_robot

    def lack(*names: str) -> None:
        def refusing(name: str) -> Any:
            if name in names:
                raise RobotError(f"robots/{name}/robot.yaml:4: the Python package of its meshes is not installed")
            return load(name)

        monkeypatch.setattr(tamp.task, "load_robot", refusing)

    return lack


def test_a_robot_that_cannot_be_used_is_named_and_another_one_moves_the_block(
    without: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("airo_models", reason="the extra 'ur5e' is missing")
    without("panda")
    assert main(["doctor"]) == 0
    said = capsys.readouterr().out
    assert "panda (cannot be used: robots/panda/robot.yaml:4" in said
    assert "solved by ur5e_2f85" in said


def test_without_any_it_is_broken_and_says_what_brings_one(without: Any, capsys: pytest.CaptureFixture[str]) -> None:
    without("panda", "ur5e_2f85")
    assert main(["doctor"]) == 1
    said = capsys.readouterr().out
    assert "none can be used: panda: robots/panda/robot.yaml:4" in said
    assert "airo-models" in said
    assert "broken or absent: robots, one block, from A to B" in said
