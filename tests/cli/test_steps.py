"""The steps one at a time, with what they say as data; completion; levels of telling."""

from __future__ import annotations

import json
import logging
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import tamp
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


def test_a_plan_that_the_checker_rejects_is_not_executed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan, poses = tmp_path / "plan.json", tmp_path / "poses.json"
    assert main(["plan", str(ONE), "-o", str(plan)]) == 0
    made = tamp.load_plan(plan)
    tamp.save_plan(replace(made, actions=made.actions[:2]), plan)
    assert main(["execute", str(ONE), str(plan), "-o", str(poses)]) == 1
    told = capsys.readouterr()
    assert "still in the hand" in told.err
    assert "--unchecked" in told.err
    assert not poses.exists()
    main(["execute", str(ONE), str(plan), "-o", str(poses), "--unchecked"])
    told = capsys.readouterr()
    assert "UNCHECKED" in told.err
    assert told.out.splitlines()[-1] == str(poses)
    assert poses.exists()


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


def test_a_plan_is_carried_out_in_the_simulator_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    task, plan = str(ONE), str(tmp_path / "plan.json")
    assert main(["plan", task, "--simulator", "pybullet", "--settling", "pybullet", "-o", plan]) == 0
    assert main(["execute", task, plan, "--simulator", "pybullet"]) == 0
    assert "done after" in capsys.readouterr().out
    assert main(["execute", task, plan, "--simulator", "gazebo"]) == 2
    assert "unknown simulator 'gazebo'; valid are pybullet" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "status", "said"),
    [
        ("Sleeps", 1, "tamp: the plan was not carried out within 5 s: simulator '{}' did not come to an end\n"),
        ("Stubborn", 1, "tamp: the plan was not carried out within 5 s: simulator '{}' did not come to an end\n"),
        ("Ends", 2, "tamp: a simulator ended the program\n"),
    ],
)
def test_a_simulator_that_does_not_come_back_is_ended(tmp_path: Path, name: str, status: int, said: str) -> None:
    pytest.importorskip("pybullet")
    plan, simulator = tmp_path / "plan.json", f"tests.cli.bad_simulators:{name}"
    tamp.save_plan(tamp.plan(tamp.load_task(ONE)), plan)
    command = [sys.executable, "-m", "tamp", "execute", str(ONE), str(plan), "--simulator", simulator]
    limit = ["--time-limit", "5", "--json", "-"]
    done = subprocess.run([*command, *limit], capture_output=True, text=True, cwd=Path(__file__).parents[2])
    assert (done.returncode, done.stderr) == (status, said.format(simulator))
    assert status == 2 or json.loads(done.stdout)["status"] == "timeout"
