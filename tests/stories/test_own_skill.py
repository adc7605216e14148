"""A skill of one's own in a package outside the repository: a button is pressed, then a box is put away.

Its PDDL, stream, timed steps and the checker's rule are five files, the tutorial's; it is planned, checked, carried out
and reported by the commands that everybody uses, and no file of ours is edited.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.docs.manual import write_files_of

TASK = """
domain: buttons
objects:
  - {name: box, shape: {box: [0.05, 0.05, 0.08]}, pose: {xyz: [0.05, 0.2, 0.04]},
     goal: {pose: {xyz: [0.05, -0.2, 0.04]}}}
regions: [{name: bell, box: {center: [-0.1, 0.0], size: [0.06, 0.06]}}]
init: [[Button, bell]]
goal: [[Pressed, bell]]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("own-skill")
    write_files_of("own_skill", root / "elsewhere")
    (root / "ring.yaml").write_text(TASK, encoding="utf-8")
    return root


def tamp(folder: Path, *arguments: str, status: int = 0) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join((str(folder / "elsewhere"), os.environ.get("PYTHONPATH", "")))
    done = subprocess.run(
        [sys.executable, "-m", "tamp.cli", *arguments],
        capture_output=True,
        text=True,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
    )
    assert done.returncode == status, done.stdout + done.stderr
    return done


def test_a_new_skill_is_five_files(folder: Path) -> None:
    assert len([file for file in (folder / "elsewhere" / "buttons").iterdir() if file.is_file()]) == 5


@pytest.fixture(scope="module")
def solved(folder: Path) -> dict[str, Any]:
    """The record of a run, whose folder is in runs/."""
    said = tamp(folder, "solve", "ring.yaml", "--trust-task-code", "--output", "runs", "--json", "-")
    (result,) = json.loads(said.stdout)
    return dict(result)


def test_it_is_planned_checked_carried_out_and_reported(folder: Path, solved: dict[str, Any]) -> None:
    trust, result = "--trust-task-code", solved
    assert result["status"] == "solved"
    assert result["goals_met"] == {"box": True, "(pressed bell)": True}
    assert (result["domain"], result["plan_checked"]) == ("buttons", True)
    (plan,) = (folder / "runs").glob("*/plan-0.json")
    assert "accepted" in tamp(folder, "check", "ring.yaml", str(plan), trust).stdout
    assert "done" in tamp(folder, "execute", "ring.yaml", str(plan), trust).stdout
    tamp(folder, "report", "runs")
    page = (folder / "runs" / "report.html").read_text(encoding="utf-8")
    assert "press bell" in page


@pytest.mark.usefixtures("solved")
def test_a_press_elsewhere_is_rejected_by_its_own_rule(folder: Path) -> None:
    text = (folder / "ring.yaml").read_text(encoding="utf-8").replace("[-0.1, 0.0]", "[-0.1, 0.1]")
    (folder / "moved.yaml").write_text(text.replace("domain:", "name: ring\ndomain:"), encoding="utf-8")
    (plan,) = (folder / "runs").glob("*/plan-0.json")
    assert "passes bell at" in tamp(folder, "check", "moved.yaml", str(plan), "--trust-task-code", status=1).stdout


@pytest.mark.usefixtures("solved")
def test_without_its_rule_an_action_is_refused_by_name(folder: Path) -> None:
    text = (folder / "ring.yaml").read_text(encoding="utf-8").replace("domain: buttons", "name: ring")
    (folder / "plain.yaml").write_text(
        text.replace("init: [[Button, bell]]\ngoal: [[Pressed, bell]]\n", ""), encoding="utf-8"
    )
    (plan,) = (folder / "runs").glob("*/plan-0.json")
    assert "no rule for action 'press'" in tamp(folder, "check", "plain.yaml", str(plan), status=1).stdout


def test_its_sampler_fits_and_strategies_are_compared_over_it(folder: Path) -> None:
    named = ["--domain", "buttons"]
    check = ["samplers", "check", "buttons.sampler:plan_press", "--stream", "plan-press", *named, "--task", "ring.yaml"]
    assert "code is run only where you trust it" in tamp(folder, *check, status=2).stderr
    assert "it fits" in tamp(folder, *check, "--trust-task-code").stdout
    contenders = ["--contender", "default", "--contender", "goals:strategy=serialized"]
    said = tamp(folder, "compare", "ring.yaml", *named, *contenders, "--no-execute", "--output", "both", "--json", "-")
    (comparison,) = json.loads(said.stdout)
    assert comparison["measures"][0]["first"]["mean"] == comparison["measures"][0]["other"]["mean"] == 100.0


def test_its_sampler_may_be_replaced(folder: Path) -> None:
    """By a copy without types, as a first try of one's own."""
    text = (folder / "elsewhere" / "buttons" / "sampler.py").read_text(encoding="utf-8")
    (folder / "elsewhere" / "mine.py").write_text(text, encoding="utf-8")
    swapped = ["--sampler", "plan-press=mine:plan_press", "--no-execute", "--output", "swapped", "--json", "-"]
    (result,) = json.loads(tamp(folder, "solve", "ring.yaml", "--trust-task-code", *swapped).stdout)
    assert result["status"] == "planned"


@pytest.mark.usefixtures("solved")
def test_a_domain_that_the_user_names_is_found_where_they_stand(folder: Path) -> None:
    """By its package alone, by the installed command, which does not look there by itself."""
    (plan,) = (folder / "runs").glob("*/plan-0.json")
    command = [sys.executable, "-P", "-c", "from tamp.cli import run; run()"]
    for arguments in (["check", "../ring.yaml", str(plan)], ["execute", "../ring.yaml", str(plan)]):
        done = subprocess.run(
            [*command, *arguments, "--domain", "buttons"], capture_output=True, text=True, cwd=folder / "elsewhere"
        )
        assert done.returncode == 0, done.stderr
