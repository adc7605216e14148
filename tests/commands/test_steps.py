"""The steps one at a time, with what they say as data; completion; levels of telling."""

from __future__ import annotations

import json
import logging
import shutil
import subprocess
from pathlib import Path

import pytest

from tamp.cli import main

ONE = Path(__file__).parents[2] / "scenarios" / "one_object.yaml"


def test_plan_check_execute_score_through_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan, poses = tmp_path / "plan.json", tmp_path / "poses.json"

    def said(*arguments: str) -> dict[str, object]:
        assert main([*arguments, "--json", "-"]) == 0
        data = json.loads(capsys.readouterr().out)
        assert isinstance(data, dict)
        return data

    planned = said("plan", str(ONE), "-o", str(plan))
    assert [str(action).partition("(")[0] for action in planned["actions"]] == ["move", "pick", "move", "place"]  # type: ignore[attr-defined]
    assert said("check", str(ONE), str(plan)) == {"accepted": True, "problems": []}
    executed = said("execute", str(ONE), str(plan), "-o", str(poses))
    assert (executed["status"], executed["grasps_succeeded"]) == ("done", 1)
    assert said("score", str(ONE), str(poses))["solved"] is True


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_completion_is_a_script_that_its_shell_reads(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert "compare" in script
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=script, text=True, check=True)


@pytest.mark.parametrize(
    ("option", "level"),
    [([], logging.WARNING), (["-v"], logging.INFO), (["-vv"], logging.DEBUG), (["-q"], logging.ERROR)],
)
def test_how_much_is_told(option: list[str], level: int) -> None:
    assert main(["robots", *option]) == 0
    assert logging.getLogger("tamp").getEffectiveLevel() == level
