"""`tamp contest run`: a solution in a sandbox, on a task in a simulator; what counts of several runs."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from tamp.cli import main
from tamp.contest.evaluation import evaluate, trial
from tamp.contest.evaluation.standings import counting, standings
from tamp.contest.evaluation.workcell import Refusal, TimeOver, Workcell
from tamp.contest.rules import Rules
from tamp.contest.sandbox.choice import KINDS, choose
from tamp.contest.sandbox.isolation import Sandbox
from tamp.contest.sandbox.plain import Plain
from tamp.errors import TampError
from tamp.execution.simulators import make_simulator
from tamp.results import Result
from tamp.scoring.ranking import Yardstick
from tamp.task import At, Box, Object, Pose, Task, load_robot

TASK = """\
name: tiny
objects:
  - {name: red, shape: {box: [0.04, 0.04, 0.06]}, pose: {xyz: [0.0, 0.1, 0.03]}, goal: {pose: {xyz: [0.0, -0.1, 0.03]}}}
"""

MOVES = """
import numpy as np
from tamp.contest.api.client import Refused
class Solution:
    def run(self, goal, robot):
        red = goal.objects["red"]
        assert red.mesh.read_text().count("\\nv ") == 8 and red.pose[1, 3] == -0.1, red
        before = robot.time_left
        q = robot.arm.state().q
        q[0] += 0.05
        robot.arm.move_joints(q)
        assert abs(robot.arm.state().q[0] - q[0]) < 0.01 and robot.time_left < before
        try:
            robot.arm.move_joints(q + 100)
        except Refused as refused:
            print("refused:", refused)
        print("tool", robot.tf("world", "tool")[:3, 3].round(2).tolist())
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "tiny.yaml").write_text(TASK)
    (tmp_path / "moves.py").write_text(MOVES)
    return tmp_path


def _isolates() -> bool:
    return any(not kind().missing() for kind in KINDS)


def test_a_solution_moves_the_arm_and_is_scored(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["contest", "run", str(folder / "moves.py"), "--tasks", str(folder / "tiny.yaml"), "--runs", "1"]
    insist = [] if _isolates() else ["--no-isolation"]
    assert main([*arguments, *insist, "-o", str(folder / "out")]) == 0
    log = (folder / "out" / "tiny-pybullet-0.log").read_text()
    assert "refused: joint" in log and "tool [" in log, log
    found = json.loads((folder / "out" / "results.json").read_text())
    (run,) = found["runs"]
    assert run["settings"] == {"ended": "finished"}
    assert run["ede_m"] == pytest.approx(run["do_nothing_ede_m"], abs=1e-3)
    assert 0 < run["execution_sim_s"] < 10
    assert "mean error" in capsys.readouterr().out
    assert main([*arguments, *insist]) == 0
    told = capsys.readouterr()
    assert "what it printed is shown by -v, and kept by -o DIR" in told.out and "refused: joint" not in told.err
    assert main([*arguments, *insist, "-v"]) == 0
    assert "tiny, pybullet, run 0: refused: joint" in capsys.readouterr().err
    before = (folder / "out" / "results.json").read_bytes()
    assert main([*arguments, *insist, "-o", str(folder / "out")]) == 2
    complaint = capsys.readouterr().err
    assert (
        "results.json has results already: --resume runs what is missing, --overwrite replaces them; nothing"
        in complaint
    )
    assert (folder / "out" / "results.json").read_bytes() == before


def test_what_cannot_be_loaded_is_refused_once(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It was imported, and failed, once a run."""
    (folder / "broken.py").write_text("print('here')\nopen('no_such')\n")
    arguments = ["contest", "run", str(folder / "broken.py"), "--tasks", str(folder / "tiny.yaml"), "-v"]
    assert main([*arguments, *([] if _isolates() else ["--no-isolation"]), "-o", str(folder / "out")]) == 2
    told = capsys.readouterr()
    assert told.err.count("here") == 1 and 'broken.py", line' not in told.out
    assert "broken.py cannot be loaded, and was not run: FileNotFoundError: [Errno 2] No such file" in told.err
    assert not (folder / "out" / "results.json").exists()


class _KilledError(Exception):
    """Comes in place of the end of the process."""


def test_what_was_killed_goes_on_with_the_runs_that_it_has(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["contest", "run", str(folder / "still.py"), "--tasks", str(folder / "tiny.yaml"), "--runs", "2"]
    arguments += ["-o", str(folder / "out"), *([] if _isolates() else ["--no-isolation"])]
    (folder / "still.py").write_text("class Solution:\n    def run(self, goal, robot): print('here')\n")
    begun = []

    def run_trial(*given: object, run: int, **more: object) -> object:
        begun.append(run)
        if len(begun) == 2:
            raise _KilledError
        return trial.run_trial(*given, run=run, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(evaluate, "run_trial", run_trial)
    with pytest.raises(_KilledError):
        main(arguments)
    assert "here" in (folder / "out" / "tiny-pybullet-0.log").read_text()
    first = (folder / "out" / "runs.jsonl").read_bytes()
    assert first.count(b"\n") == 1 and not (folder / "out" / "results.json").exists()
    assert main(arguments) == 2
    assert "runs.jsonl has results already: --resume runs what is missing" in capsys.readouterr().err
    with (folder / "out" / "runs.jsonl").open("ab") as file:
        file.write(b'{"task": "tiny", "se')  # as where the disk, or the process, ended
    assert main([*arguments, "--resume"]) == 0
    assert begun == [0, 1, 1]
    assert (folder / "out" / "runs.jsonl").read_bytes().startswith(first)
    assert [run["seed"] for run in json.loads((folder / "out" / "results.json").read_text())["runs"]] == [0, 1]
    assert main([*arguments, "--resume"]) == 0
    assert begun == [0, 1, 1]
    (folder / "still.py").write_text("class Solution:\n    def run(self, goal, robot): print('there')\n")
    assert main([*arguments, "--resume"]) == 0
    assert begun == [0, 1, 1, 0, 1]


def test_runs_that_are_known_are_not_repeated(folder: Path) -> None:
    from tamp.contest.evaluation.evaluate import solution_path
    from tamp.task.files.load import load_task

    seen: list[trial.Trial] = []
    task, rules = load_task(folder / "tiny.yaml"), Rules(runs=2)
    known = [_result("tiny", "pybullet", 1, 0.123)]
    sandbox = choose(insecure=not _isolates())
    found = evaluate.evaluate(solution_path("nothing"), [task], rules, sandbox, seen.append, known)
    assert [(result.seed, result.ede_m == 0.123) for result in found] == [(0, False), (1, True)]
    assert [one.result.seed for one in seen] == [0]


def test_a_sandbox_that_does_not_begin_is_no_run_that_counts(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It was scored as one in which nothing was done, and the command went well."""
    monkeypatch.setattr(Plain, "command", lambda *_: ["/bin/sh", "-c", "echo no room today; exit 3"])
    command = ["contest", "run", str(folder / "moves.py"), "--tasks", str(folder / "tiny.yaml"), "--runs", "1"]
    assert main([*command, "--no-isolation"]) == 2
    said = capsys.readouterr().err
    assert "the sandbox did not begin: the process ended with status 3" in said and "no room today" in said


def test_without_isolation_it_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for kind in KINDS:
        monkeypatch.setattr(kind, "missing", lambda _: "the kernel refuses")
    with pytest.raises(TampError, match="insist with --no-isolation"):
        choose()
    insisted: Sandbox = choose(insecure=True)
    assert not insisted.isolates


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["no_such"], "there is no solution"),
        (["nothing"], "no task to run on"),
        (["nothing", "--tasks", "x.yaml", "--sandbox", "wall"], "x.yaml"),
    ],
)
def test_bad_input_gets_one_sentence(arguments: list[str], complaint: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["contest", "run", *arguments]) == 2
    error = capsys.readouterr().err
    assert complaint in error and len(error.splitlines()) == 1


HANGS = """
import time
from tamp.execution.simulators import SIMULATORS, load_simulator
class Hangs(load_simulator(next(name for name, entry in SIMULATORS.items() if entry.installed))):
    def step(self, count=1):
        time.sleep(1e6)
"""


def test_a_simulator_from_the_working_folder_is_found_and_ended_where_it_hangs(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if path])
    monkeypatch.setattr("tamp.contest.evaluation.trial.BEYOND_S", 1.0)
    (folder / "hanging.py").write_text(HANGS)
    options = ["--tasks", "tiny.yaml", "--simulator", "hanging:Hangs", "--runs", "1", "--wall", "2"]
    assert main(["contest", "run", "moves.py", *options, "--no-isolation"]) == 2
    said = "tamp: simulator 'hanging:Hangs' did not come back within the 2 s that a run may take\n"
    assert capsys.readouterr().err.endswith(said)


def test_the_workcell_refuses_what_cannot_be_done_and_ends_in_time() -> None:
    item = Object("red", Box((0.04, 0.04, 0.06)), Pose((0.0, 0.1, 0.03)), At(Pose((0.0, -0.1, 0.03))))
    task = Task("tiny", (item,))
    with make_simulator("pybullet", task.objects, robot=load_robot("panda")) as world:
        cell = Workcell(task, world, (), {}, seed=0, limit_s=3.0)
        q = cell.state()[0]
        for times, positions, complaint in (
            ([0.0, 1.0], [q, q + 3.0], "leave its range"),
            ([0.0, 0.01], [q, q + 0.1], "times its largest speed"),
            ([0.0, 1.0], [q + 0.2, q], "from where the arm is"),
            ([0.0, 0.0], [q, q], "increase"),
            ([0.0, 1e9], [q, q], "are left"),
            ([0.0], [q, q], "shape"),
        ):
            with pytest.raises(Refusal, match=complaint):
                cell.follow(np.array(times), np.array(positions), None)
        swing = np.outer([-0.9, 0.9], cell.robot.spec.velocity)
        with pytest.raises(Refusal, match="leave its range"):
            cell.follow(np.array([0.0, 2.9]), np.array([q, q]), swing)
        out_of_reach = np.eye(4)
        out_of_reach[0, 3] = 5.0
        for straight in (True, False):
            with pytest.raises(Refusal, match="cannot reach"):
                cell.move_pose(out_of_reach, 1.0, straight)
        with pytest.raises(Refusal, match="no pose"):
            cell.move_pose(2 * np.eye(4), 1.0, True)
        with pytest.raises(Refusal, match="no camera"):
            cell.picture("eye")
        cell.go_to(0.0, 20.0)
        assert (cell.grasps.attempted, cell.grasps.succeeded) == (1, 0)
        with pytest.raises(TimeOver):
            cell.wait(10.0)
        assert cell.time_left == 0.0


@pytest.mark.parametrize("simulator", ["pybullet", "mujoco"])
def test_fingers_that_meet_nothing_are_at_their_width_when_the_call_returns(simulator: str) -> None:
    pytest.importorskip(simulator)
    item = Object("red", Box((0.04, 0.04, 0.06)), Pose((0.0, 0.1, 0.03)), At(Pose((0.0, -0.1, 0.03))))
    with make_simulator(simulator, (item,), robot=load_robot("panda")) as world:
        cell = Workcell(Task("tiny", (item,)), world, (), {}, seed=0, limit_s=60.0)
        for width in (0.05, 0.02, 0.06, 0.0):
            cell.go_to(width, 1000.0)
            assert cell.state()[2] == pytest.approx(width, abs=1.5e-3)


def _result(task: str, simulator: str, run: int, ede_m: float, time: float = 1.0) -> Result:
    return Result(task, run, "failed", ede_m=ede_m, execution_sim_s=time, simulator=simulator)


YARDSTICKS = (Yardstick("a", 0.3, 0.5), Yardstick("b", 0.3, 0.5))
RUNS = tuple(
    _result(task, simulator, run, ede_m)
    for simulator, task, errors in (
        ("one", "a", (0.20, 0.10)),
        ("one", "b", (0.10, 0.30)),
        ("two", "a", (0.05, 0.25)),
        ("two", "b", (0.25, 0.25)),
    )
    for run, ede_m in enumerate(errors)
)


@pytest.mark.parametrize(
    ("simulators", "runs", "error"),
    [
        ("solution", "task", 0.10),  # one: 0.10 and 0.10; two: 0.05 and 0.25
        ("task", "task", 0.075),
        ("mean", "mean", 0.1875),
        ("solution", "solution", 0.15),  # one, run 0: 0.20 and 0.10; two, run 0: 0.05 and 0.25
    ],
)
def test_bests_are_as_the_rules_have_them(simulators: str, runs: str, error: float) -> None:
    rules = Rules(best_of_simulators=simulators, best_of_runs=runs)  # type: ignore[arg-type]
    assert standings({"x": RUNS}, YARDSTICKS, rules)[0].mean.error_m == pytest.approx(error)


def test_tasks_by_which_nothing_is_scored_are_refused_before_anything_is_run(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shelf = "regions: [{name: shelf, box: {center: [0.1, 0.1], size: [0.2, 0.2]}}]\n"
    (folder / "on.yaml").write_text(TASK.replace("{pose: {xyz: [0.0, -0.1, 0.03]}}", "{on: shelf}") + shelf)
    assert main(["contest", "run", str(folder / "moves.py"), "--tasks", str(folder / "on.yaml")]) == 2
    assert capsys.readouterr().err == "tamp: none of the tasks has a goal pose, by which a solution is scored\n"


def test_equal_errors_are_told_apart_by_time_and_nothing_done_counts() -> None:
    solutions = {"slow": [_result("a", "one", 0, 0.1, 9.0)], "fast": [_result("a", "one", 0, 0.1, 2.0)], "none": []}
    found = standings(solutions, YARDSTICKS, Rules())
    assert [(s.rank, s.solution) for s in found] == [(1, "fast"), (2, "slow"), (3, "none")]
    assert found[2].mean.error_m == pytest.approx(0.3)
    assert counting([], YARDSTICKS, Rules()) == ()
