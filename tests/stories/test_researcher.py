"""A researcher's sampler, in a package of its own outside the repository: checked, swapped in by each of the four ways,
compared against the default over ten tasks, and the report opened."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.browser import CHROMIUM, look

SAMPLER = '''
"""Grasps from above: the first thing that one tries."""

import math

from tamp import Grasp, Pose


def from_above(context, obj):
    """Yield grasps of a box across either side, a little below its top."""
    x, y, z = context.scene.task.object(obj).shape.size
    for width, yaw in ((y, 0.0), (x, math.pi / 2), (y, math.pi), (x, -math.pi / 2)):
        if width < 0.075:
            yield Grasp(Pose.from_rpy((0.0, 0.0, z / 2 - 0.02), (math.pi, 0.0, yaw)), width)
'''

DOMAIN = '''
"""A domain of one's own: the tabletop's with other defaults."""

from tamp.domains import tabletop
from tamp.domains.skill import Skill

GRASPS = Skill("grasps from above", samplers={"sample-grasp": "graspkit.above:from_above"})
DOMAIN = tabletop.DOMAIN.extended(GRASPS, name="from-above")
'''

FIRST_GRASP = """
from tamp.domains.samplers import resolve_samplers
from tamp.domains.catalog import load_domain
print(resolve_samplers(load_domain("graspkit.domain").samplers)["sample-grasp"].__module__)
"""

FROM_PYTHON = """
import tamp
from graspkit.above import from_above
plan = tamp.plan(tamp.load_task("task0.yaml"), samplers={"sample-grasp": from_above})
print(len(plan.actions))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with ten tasks of one box, and a package beside it that only PYTHONPATH knows."""
    root = tmp_path_factory.mktemp("researcher")
    package = root / "elsewhere" / "graspkit"
    package.mkdir(parents=True)
    for name, text in (("__init__", ""), ("above", SAMPLER), ("domain", DOMAIN)):
        (package / f"{name}.py").write_text(text, encoding="utf-8")
    for i in range(10):
        x = round(-0.05 + 0.015 * i, 3)
        box = f"{{name: box, shape: {{box: [0.05, 0.05, 0.08]}}, pose: {{xyz: [{x}, 0.2, 0.04]}}, "
        task = f"objects: [{box}goal: {{pose: {{xyz: [{x}, -0.2, 0.04]}}}}}}]\n"
        (root / f"task{i}.yaml").write_text(task, encoding="utf-8")
    task = (root / "task0.yaml").read_text(encoding="utf-8")
    (root / "asking.yaml").write_text(task + "samplers: {sample-grasp: graspkit.above:from_above}\n", encoding="utf-8")
    return root


def run(folder: Path, *command: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(folder / "elsewhere")}
    done = subprocess.run(
        [sys.executable, *command], capture_output=True, text=True, cwd=folder, env=environment, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def tamp(folder: Path, *arguments: str) -> str:
    return run(folder, "-m", "tamp.cli", *arguments)


def test_the_sampler_fits(folder: Path) -> None:
    assert "it fits" in tamp(
        folder, "samplers", "check", "graspkit.above:from_above", "--stream", "sample-grasp", "--task", "task0.yaml"
    )


def test_it_is_swapped_in_by_each_of_four_ways(folder: Path) -> None:
    assert run(folder, "-c", FROM_PYTHON).split() == ["4"]
    option = ["--sampler", "sample-grasp=graspkit.above:from_above"]
    by_option = json.loads(tamp(folder, "plan", "task0.yaml", *option, "--json", "-"))
    by_task = json.loads(tamp(folder, "plan", "asking.yaml", "--trust-task-code", "--json", "-"))
    assert len(by_option["actions"]) == len(by_task["actions"]) == 4
    assert "graspkit.above:from_above  (by the task" in tamp(folder, "samplers", "--task", "asking.yaml")
    assert run(folder, "-c", FIRST_GRASP).split() == ["graspkit.above"]


def test_it_is_compared_over_ten_tasks_and_the_report_opened(folder: Path, tmp_path: Path) -> None:
    tasks = [f"task{i}.yaml" for i in range(10)]
    contenders = ["--sampler", "default", "--sampler", "sample-grasp=graspkit.above:from_above"]
    said = tamp(
        folder, "compare", *tasks, *contenders, "--no-execute", "--workers", "2", "--output", "out", "--json", "-"
    )
    (comparison,) = json.loads(said)
    assert comparison["pairs"] == 10
    solved = comparison["measures"][0]
    assert solved["first"]["mean"] == solved["other"]["mean"] == 100.0
    page = folder / "out" / "comparison.html"
    assert "graspkit.above:from_above" in page.read_text(encoding="utf-8")
    if CHROMIUM is None:
        pytest.skip("no chromium to open the report in; everything before was checked")
    assert look(page.as_uri(), tmp_path / "page.png") == []
