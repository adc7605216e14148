"""A skill of one's own in a package outside the repository: a button is pressed, then a box is put away.

Its PDDL, stream, timed steps and the checker's rule are five files; it is planned, checked, carried out and reported by
the commands that everybody uses, and no file of ours is edited.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

PACKAGE = {
    "domain.pddl": """
(define (domain press)
  (:predicates (Button ?b) (PressMotion ?b ?q ?m) (Pressed ?b))
  (:action press
    :parameters (?b ?q ?m)
    :precondition (and (PressMotion ?b ?q ?m) (AtConf ?q) (HandEmpty))
    :effect (Pressed ?b)))
""",
    "stream.pddl": """
(define (stream press)
  (:stream plan-press
    :inputs (?b)
    :domain (Button ?b)
    :outputs (?q ?m)
    :certified (and (Conf ?q) (PressMotion ?b ?q ?m))))
""",
    "sampler.py": '''
"""Where the arm presses from, and how."""

import numpy as np

from tamp import Pose
from tamp.streams.values import ArmPath, Configuration
from tamp.world.kinematics.inverse import inverse, straight_line
from tamp.world.scene import Scene

ABOVE, DOWN = 0.15, 0.03  # of the tool over the table, before and while pressing [m]


def plan_press(context, button):
    """Yield a configuration over the button and the way down to it and up again."""
    workspace = context.scene
    x, y = workspace.region(button).center
    robot = workspace.world.robot
    poses = {name: place.pose.matrix for name, place in workspace.start.items()}
    checker = workspace.world.checker(Scene(poses, opening=0.0))
    above, down = (Pose.from_rpy((x, y, z), (np.pi, 0.0, 0.0)).matrix for z in (ABOVE, DOWN))
    for q in inverse(robot, above, context.rng, checker=checker):
        way = straight_line(robot, q, down)
        if way is not None and checker.path_free(way):
            yield Configuration(tuple(q), 0.0), ArmPath(np.concatenate([way, way[-2::-1]]))
    context.fail(f"no way down to {button}")
''',
    "rules.py": '''
"""The checker's rule: the closed hand comes down over the middle of the button, touching nothing."""

import numpy as np

from tamp.checking.actions.rule import carry_out, has_steps, needs_empty_hand

NEAR = 0.04  # of the tool to the middle of the button on the table [m]


class Press:
    """An action `press(button)`: one motion, after which the button is pressed."""

    def check(self, replay, action):
        """Judge the motion, and where its lowest point is."""
        if not has_steps(replay, action):
            return
        needs_empty_hand(replay, action)
        (button,), (move,) = action.arguments, action.steps
        region = next(r for r in replay.scene.task.regions if r.name == button)
        tools = replay.scene.links.tree.tool(move.trajectory.positions)
        lowest = tools[tools[:, 2, 3].argmin(), :3, 3]
        off = float(np.linalg.norm(lowest - (*region.center, 0.0)))
        if off > NEAR:
            replay.report("precondition", f"the hand passes {button} at {1000 * off:.0f} mm", (button,), off)
        carry_out(replay, move)
        replay.state.facts.add(("pressed", button))


RULES = {"press": Press()}
''',
    "__init__.py": '''
"""Press buttons beside pick and place."""

from pathlib import Path

from tamp.domains import tabletop
from tamp.domains.skill import FactChange, SceneChange, Skill
from tamp.task import Action

FOLDER = Path(__file__).parent


def steps(timing, action):
    button, start, motion = action.args
    return Action("press", (button,), (timing.move("transit", motion.points, start.opening),))


PRESS = Skill(
    name="press",
    actions=("press",),
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={"plan-press": "buttons.sampler:plan_press"},
    steps=steps,
    facts=lambda action: FactChange(added=(("pressed", action.arguments[0]),)),
    rules="buttons.rules:RULES",
    words={"press": "press {0}"},
)
DOMAIN = tabletop.DOMAIN.extended(PRESS, name="buttons", strategy="all-at-once")
''',
}

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
    package = root / "elsewhere" / "buttons"
    package.mkdir(parents=True)
    for name, text in PACKAGE.items():
        (package / name).write_text(text.lstrip(), encoding="utf-8")
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


def test_a_new_skill_is_five_files() -> None:
    assert len(PACKAGE) <= 6


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
