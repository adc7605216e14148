"""Samplers of one's own for every stream of the tabletop, in one file outside the repository: they change what they do.

Here each passes on what the default gives and notes that it was asked, so the plan stays the same to the hash.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tamp.domains.tabletop import DOMAIN

SCENARIOS = Path(__file__).parents[2] / "scenarios"
MINE = '''
"""A sampler for each stream: `serve_sample_grasp` serves sample-grasp, and so on."""

from pathlib import Path

from tamp.domains.samplers import load_sampler
from tamp.domains.tabletop import DOMAIN

TESTS = {stream.name for stream in DOMAIN.stream_file.streams if not stream.outputs}


def serving(name, default):
    def note():
        with Path("asked.txt").open("a") as file:
            print(name, file=file)

    def test(*arguments):
        note()
        return default(*arguments)

    def draw(*arguments):
        note()
        yield from default(*arguments)

    return test if name in TESTS else draw


for _name, _address in DOMAIN.samplers.items():
    globals()["serve_" + _name.replace("-", "_")] = serving(_name, load_sampler(_address, _name))
'''


def plan_of(folder: Path, scenario: str, *options: str) -> str:
    path = os.pathsep.join((str(folder), os.environ.get("PYTHONPATH", "")))
    command = [sys.executable, "-m", "tamp", "plan", str(SCENARIOS / f"{scenario}.yaml"), "--json", "-", *options]
    environment = {**os.environ, "PYTHONPATH": path}
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    digest: str = json.loads(done.stdout)["plan_sha256"]
    return digest


@pytest.mark.parametrize("scenario", ["slide_box", "regrasp_into_box"])
def test_one_file_serves_every_stream(tmp_path: Path, scenario: str) -> None:
    (tmp_path / "mine.py").write_text(MINE, encoding="utf-8")
    served = [f"--sampler={name}=mine:serve_{name.replace('-', '_')}" for name in DOMAIN.samplers]
    assert plan_of(tmp_path, scenario, *served) == plan_of(tmp_path, scenario)
    asked = set((tmp_path / "asked.txt").read_text(encoding="utf-8").split())
    assert {"sample-grasp", "plan-free-motion"} & asked
