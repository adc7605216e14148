"""The command: usage, exit statuses, and one honest sentence where the input is wrong."""

from __future__ import annotations

import dataclasses
import json
import signal
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

import tamp
from tamp.cli import main, parser
from tamp.cli.batches import Ended
from tamp.cli.options import settings_given
from tamp.errors import TaskError
from tamp.pipeline.options.settings import Settings
from tamp.results import Result, read_results
from tamp.versions import how_to_install, versions

SCENARIOS = Path(__file__).parents[2] / "scenarios"

BLOCK = (
    "{name: a, shape: {box: [0.05, 0.05, 0.08]}, pose: {xyz: [0.1, 0.2, 0.04]}, goal: {pose: {xyz: [0.1, -0.2, 0.04]}}}"
)


@pytest.fixture
def task(tmp_path: Path) -> Path:
    path = tmp_path / "block.yaml"
    path.write_text(f"objects: [{BLOCK}]\n", encoding="utf-8")
    return path


BAD = {
    "empty": ("", "is empty"),
    "list": ("- 1\n", "not a mapping"),
    "nan": (f"objects: [{BLOCK.replace('0.08', '.nan')}]", "finite number"),
    "field": (f"objects: [{BLOCK}]\nrobots: panda\n", "did you mean robot?"),
    "robot": (f"objects: [{BLOCK}]\nrobot: hal\n", "unknown robot 'hal'"),
    "strategy": (f"objects: [{BLOCK}]\nstrategy: serial\n", "unknown strategy 'serial'; did you mean 'serialized'?"),
    "off": (f"objects: [{BLOCK.replace('-0.2', '-2')}]", "objects[0].goal.pose: a is off the table"),
    "fold": (f"objects: [{BLOCK[:-1]}, symmetry: {{z: -3}}}}]", "-3 is not valid; it must be 1, 2, 3"),
    "target": (f"objects: [{BLOCK[: BLOCK.index(' goal')]} goal: {{on: shelv}}}}]", "the task has nothing to be on"),
    "mesh": ("objects: [{name: a, shape: {mesh: no.obj}, pose: {xyz: [0, 0, 0]}}]", "there is no file no.obj"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_sentence_and_status_two(
    tmp_path: Path, task: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    text, said = BAD[name]
    path = tmp_path / f"{name}.yaml"
    path.write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    assert main(["solve", str(path), str(task), "--output", str(out)]) == 2
    output = capsys.readouterr()
    assert said in output.err
    assert output.err.startswith(f"tamp: {path}")
    assert output.err.count("\n") == 1
    assert not out.exists(), "nothing runs where one file is bad"


@pytest.mark.parametrize(
    "arguments",
    [
        [], ["nonsense"], ["solve", "t.yaml", "--seed", "-1"], ["solve", "t.yaml", "--timeout", "nan"],
        ["solve", "t.yaml", "--workers", "0"], ["solve", "t.yaml", "--sampler", "x"], ["import", "ocrtoc", "F"],
        ["solve", "t.yaml", "--algorithm", "magic"],
    ],
)  # fmt: skip
def test_wrong_usage_is_status_two(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as status:
        main(arguments)
    assert status.value.code == 2


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (["slove"], "there is no command 'slove'; did you mean solve?"),
        (["solve", "t.yaml", "--tmeout", "3"], "did you mean --timeout?"),
        (["solve", "t.yaml", "--algorithm", "adaptve"], "did you mean adaptive?"),
        (["samplers", "chek"], "did you mean check?"),
        (["--seed", "3", "solve", "t.yaml"], "options stand behind the command they are for"),
    ],
)
def test_what_was_meant_is_said(arguments: list[str], meant: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as status:
        main(arguments)
    said = capsys.readouterr().err
    assert (status.value.code, said.count("\n")) == (2, 1)
    assert meant in said


@pytest.mark.parametrize("way", [["-m", "tamp"], ["-m", "tamp.cli"]])
def test_the_command_is_a_module_too(way: list[str]) -> None:
    done = subprocess.run([sys.executable, *way, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"tamp {versions()['tabletop-tamp']}\n"


def test_every_option_of_the_settings_is_a_flag_of_every_command_that_plans() -> None:
    flags = [field.name for field in dataclasses.fields(Settings) if "help" in field.metadata]
    assert "algorithm" in flags
    for command in (
        ["solve", "t.yaml"],
        ["plan", "t.yaml"],
        ["compare", "t.yaml", "--output", "o", "--sampler", "x=a:b"],
    ):
        options = parser().parse_args(command)
        assert settings_given(options) == {}, "what is not named is the task's to say"
        assert all(hasattr(options, flag) for flag in flags)
    assert settings_given(parser().parse_args(["plan", "t.yaml", "--clock", "processor"])) == {"clock": "processor"}
    tuned = settings_given(parser().parse_args(["plan", "t.yaml", "--tuning", "first_plan_share=0.5"]))
    assert Settings(**tuned).tuning.first_plan_share == 0.5
    words = ["plan", "t.yaml", "--tuning", "max_replans=3", "--tuning", "approaches_m=0.06,0.04"]
    tuned = settings_given(parser().parse_args(words))
    assert Settings(**tuned).tuning.changed() == {"max_replans": 3, "approaches_m": (0.06, 0.04)}


def test_solve_without_tasks_and_resume_without_output_are_refused(
    task: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["solve"]) == 2
    assert main(["solve", str(task), "--resume"]) == 2
    assert "--resume needs --output" in capsys.readouterr().err


def test_an_unknown_stream_is_refused_before_anything_runs(task: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", str(task), "--sampler", "sample-grasps=a:b"]) == 2
    assert "did you mean 'sample-grasp'" in capsys.readouterr().err


def test_score_takes_poses_from_any_source(tmp_path: Path, task: Path, capsys: pytest.CaptureFixture[str]) -> None:
    poses = tmp_path / "poses.yaml"
    for text, status in (
        ("a: {xyz: [0.1, -0.2, 0.04]}", 0),
        ("a: {xyz: [0.1, -0.2, 0.04], rpy: [0, 0, 3]}", 1),
        ("a: null", 1),
        ("b: null", 2),
        ("a: {xyz: [0, 0]}", 2),
        ("a: [0, 0, 0]", 2),
        ("a: {xyz: [0, 0, 0], quat: [0, 0, 0, 0]}", 2),
    ):
        poses.write_text(text, encoding="utf-8")
        assert main(["score", str(task), str(poses), "--json", str(tmp_path / "score.json")]) == status, text
    assert json.loads((tmp_path / "score.json").read_text(encoding="utf-8"))["lost"] == ["a"]
    capsys.readouterr()


@pytest.mark.parametrize("command", ["robots", "domains", "samplers"])
def test_what_is_installed_is_listed(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command]) == 0
    assert {"robots": "panda", "domains": "tabletop", "samplers": "sample-grasp("}[command] in capsys.readouterr().out


def test_a_reader_that_leaves_early_is_no_traceback() -> None:
    command = f"{sys.executable} -m tamp.cli samplers | head -n 1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    assert "Traceback" not in done.stderr


def test_solve_writes_what_it_promises(tmp_path: Path, task: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One block from end to end through the command, then again by --resume, which runs nothing, and by --replay."""
    out = tmp_path / "out"
    arguments = ["solve", str(task), "--output", str(out), "--json", str(tmp_path / "all.json")]
    assert main(arguments) == 0
    assert "1 of 1 solved" in capsys.readouterr().out
    (result,) = read_results(out / "results.jsonl")
    assert json.loads((tmp_path / "all.json").read_text(encoding="utf-8"))[0] == result.as_dict()
    assert (result.status, result.plan_checked, result.ede_m is not None and result.ede_m < 0.03) == (
        "solved",
        True,
        True,
    )
    names = {path.name for path in (out / "block-0").iterdir()}
    assert {"manifest.json", "result.json", "poses.json", "plan-0.json", "report.txt"} <= names
    assert main([*arguments, "--resume", "-v"]) == 0
    again = capsys.readouterr()
    assert " kept=1 " in again.out
    assert "block, seed 0: solved, kept" in again.err
    assert read_results(out / "results.jsonl") == (result,)
    assert main(["check", str(task), str(out / "block-0" / "plan-0.json")]) == 0
    assert main(["score", str(task), str(out / "block-0" / "poses.json")]) == 0
    capsys.readouterr()
    assert main(["solve", "--replay", str(out / "block-0"), "--json", "-"]) == 0
    told = capsys.readouterr()
    assert "the same plan" in told.err
    assert json.loads(told.out)[0]["plan_sha256"] == result.plan_sha256
    assert main(["solve", str(task), "--replay", str(out / "block-0"), "--strategy", "serialized"]) == 2
    assert "cannot be given with TASK.yaml, --strategy; it takes --trust-task-code, --json" in capsys.readouterr().err


def test_results_are_kept_by_default_where_the_last_line_says(
    tmp_path: Path, task: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["solve", str(task), "--no-execute"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    folder = Path(last.rpartition("output=")[2])
    assert last.startswith("summary: ")
    assert len(read_results(folder / "results.jsonl")) == 1
    assert main(["solve", str(task), "--no-execute", "--output", str(folder)]) == 2
    assert "has results already" in capsys.readouterr().err


def test_invalid_tasks_can_be_skipped_and_clashing_files_are_named(
    tmp_path: Path, task: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.yaml").write_text("objects: 3", encoding="utf-8")
    (tmp_path / "air.yaml").write_text(f"objects: [{BLOCK.replace('-0.2, 0.04', '-0.2, 0.4')}]\n", encoding="utf-8")
    seeds = ["--seed", "0", "--seed", "1"]
    assert main(["solve", "bad.yaml", "air.yaml", str(task), "--no-execute", "--skip-invalid", *seeds]) == 0
    said = capsys.readouterr()
    assert said.err.startswith("tamp: skipped: bad.yaml:1: objects: 3 is not valid")
    assert said.err.count("tamp: skipped: air.yaml:1: objects[0].goal.pose: nothing supports a there") == 1
    assert said.err.count("\n") == 2
    assert " invalid=2 error=0 skipped=2 " in said.out
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "block.yaml").write_bytes(task.read_bytes())
    assert main(["solve", str(task), "other/block.yaml", "--no-execute"]) == 2
    said = capsys.readouterr().err
    assert str(task) in said
    assert "other/block.yaml both are 'block'" in said


def test_links_that_lead_nowhere_are_named_and_a_file_given_twice_is_one_task(
    tmp_path: Path, task: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, target in (("circle.yaml", "circle.yaml"), ("gone.yaml", "no.yaml"), ("again.yaml", task.name)):
        (tmp_path / name).symlink_to(target)
    arguments = ["solve", "circle.yaml", "gone.yaml", str(task), "again.yaml", task.name, "--no-execute"]
    assert main([*arguments, "--skip-invalid"]) == 0
    said = capsys.readouterr()
    circle, gone = said.err.splitlines()
    assert circle.startswith("tamp: skipped: circle.yaml: cannot be read: Too many levels")
    assert gone == "tamp: skipped: gone.yaml: cannot be read: it links to no.yaml, which does not exist"
    assert "summary: total=1 " in said.out
    assert main(["solve", str(task), "--robot", "circle.yaml"]) == 2
    assert main(["report", "circle.yaml"]) == 2
    assert capsys.readouterr().err.count("\n") == 2


def test_no_output_is_written_over_another(
    tmp_path: Path, task: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    solve = ["solve", str(task), "--no-execute", "--output", "out"]
    for outputs, other in (
        (["--json", "out/results.jsonl"], "the results of the batch itself"),
        (["--csv", "out/../out/results.jsonl"], "the results of the batch itself"),
        (["--json", "x", "--csv", "x"], "--json"),
        (["--json", "-", "--csv", "-"], "--json"),
    ):
        assert main([*solve, *outputs]) == 2
        assert f"{outputs[-1]} is where {other} would be written, too" in capsys.readouterr().err
    assert main([*solve, "--csv", "-"]) == 0
    assert [line.split(",")[0] for line in capsys.readouterr().out.splitlines()] == ["task", "block"]
    with pytest.raises(SystemExit, match="2"):  # another command's JSON would replace it, too
        main(["doctor", "--json", "out/results.jsonl"])
    assert len(read_results(tmp_path / "out" / "results.jsonl")) == 1


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGHUP])
def test_who_is_told_to_end_says_how_to_go_on(sign: signal.Signals, tmp_path: Path, task: Path) -> None:
    command = [sys.executable, "-m", "tamp", "solve", str(task), "--seed", "0-9", "-v", "--output", str(tmp_path / "o")]
    listens = partial(signal.signal, sign, signal.SIG_DFL)  # what `nohup` starts ignores SIGHUP, and so do its children
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, preexec_fn=listens
    ) as process:
        assert process.stderr is not None
        assert "seed 0: solved" in process.stderr.readline()
        process.send_signal(sign)
        said = process.stderr.read()
    assert process.returncode == 130
    assert "runs did not end; the same command with --resume" in said.splitlines()[-1]
    assert "Traceback" not in said


def test_a_task_that_names_code_is_refused_until_it_is_trusted(
    tmp_path: Path, task: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("open('ran', 'w').close()\ngrasps = None\n", encoding="utf-8")
    (tmp_path / "yaml.py").write_text("open('ran', 'w').close()\n", encoding="utf-8")
    plain = task.read_text(encoding="utf-8")
    for field in (
        "samplers: {sample-grasp: mine:grasps}\n",
        "domain: mine.domain\n",
        "strategy: mine:plan\n",
        "search: mine:find\n",
    ):
        task.write_text(plain + field, encoding="utf-8")
        for command in (["solve"], ["plan"]):
            assert main([*command, str(task)]) == 2
            said = capsys.readouterr().err
            assert said.startswith(f"tamp: {task}:2: ")
            assert "--trust-task-code" in said
        with pytest.raises(TaskError, match="trust_task_code=True"):
            tamp.solve(tamp.load_task(task))
    assert not (tmp_path / "ran").exists()
    assert main(["samplers", "--task", str(task)]) == 0
    task.write_text(plain + "samplers: {sample-grasp: mine:grasps}\n", encoding="utf-8")
    assert main(["plan", str(task), "--trust-task-code"]) == 2, "now it is imported, and found to be no function"
    assert (tmp_path / "ran").exists()


@pytest.mark.parametrize("named", [{"strategy": "mine:X"}, {"settling": "mine:X"}, {"domain": "mine"}])
def test_a_run_that_names_code_is_not_repeated_until_it_is_trusted(
    named: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("open('ran', 'w').close()\n", encoding="utf-8")
    record = {"task_path": "t.yaml", "inputs": {}, "configuration": {"samplers": {}, "simulator": "pybullet", **named}}
    manifest = {"format": "tamp-manifest", "version": 1, **record}
    (tmp_path / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    assert main(["solve", "--replay", str(tmp_path)]) == 2
    assert f"the run used {next(iter(named.values()))}; code is run only where you trust it" in capsys.readouterr().err
    assert not (tmp_path / "ran").exists()


def test_a_task_that_physics_refutes_is_invalid(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "air.yaml"
    path.write_text(f"objects: [{BLOCK.replace('-0.2, 0.04', '-0.2, 0.4')}]\n", encoding="utf-8")
    assert main(["solve", str(path)]) == 2
    assert "air.yaml:1: objects[0].goal.pose: nothing supports a" in capsys.readouterr().err


def test_a_file_after_perceive_is_no_perceiver(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["solve", "--perceive", "a.yaml"])
    assert "a.yaml is a file, no name; put files before this option, or =NAME" in capsys.readouterr().err


def test_a_perceiver_that_is_none_is_refused(task: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", str(task), "--perceive", "eyes"]) == 2
    assert "unknown perceiver 'eyes'; valid are fit and package.module:function" in capsys.readouterr().err


def test_a_plan_is_made_from_given_poses_only(task: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", str(task), "--perceive"]) == 2
    assert "perceive belongs to `tamp solve`" in capsys.readouterr().err


def test_an_extra_that_names_another_is_told_by_what_that_consists_of() -> None:
    told = how_to_install("contest")
    assert "fastapi" in told and "embreex" in told and "tabletop-tamp" not in told


def test_who_breaks_a_batch_off_is_told_what_is_left(capsys: pytest.CaptureFixture[str]) -> None:
    ended = Ended([[Result("a", 0, "solved")]], kept=0, total=4, interrupted=True)
    with pytest.raises(
        KeyboardInterrupt, match="3 of 4 runs did not end; the same command with --resume --output runs"
    ):
        ended.refuse_interrupted(Path("runs"))
    replace(ended, interrupted=False).refuse_interrupted(Path("runs"))


@pytest.mark.parametrize("option", ["--strategy", "--search", "--simulator", "--settling", "--perceive"])
def test_what_is_named_by_its_address_is_found_where_one_stands(
    option: str, tmp_path: Path, task: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    name = f"standing{option.replace('-', '_')}"
    (tmp_path / f"{name}.py").write_text("")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [folder for folder in sys.path if folder])
    assert main(["solve", str(task), option, f"{name}:nothing"]) == 2
    said = capsys.readouterr().err
    assert name in sys.modules, said
    assert "'nothing'" in said
