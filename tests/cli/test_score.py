"""`tamp score`: any metric from the command line, and rankings of results folders."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tamp.cli import main
from tamp.results import Result, to_json

BOX = (
    "{{name: {0}, shape: {{box: [0.06, 0.06, 0.06]}}, pose: {{xyz: [0.1, {1}, 0.03]}}, "
    "goal: {{pose: {{xyz: [0.1, {2}, 0.03]}}}}}}"
)


@pytest.fixture
def task(tmp_path: Path) -> Path:
    path = tmp_path / "pair.yaml"
    boxes = ", ".join(BOX.format(*row) for row in (("a", 0.2, -0.2), ("b", -0.2, 0.2)))
    path.write_text(f"level: 2\nobjects: [{boxes}]\n", encoding="utf-8")
    return path


@pytest.fixture
def poses(tmp_path: Path) -> Path:
    path = tmp_path / "poses.yaml"
    path.write_text("a: {xyz: [0.1, 0.2, 0.03]}\nb: {xyz: [0.1, -0.1, 0.03]}\n", encoding="utf-8")
    return path


def test_a_metric_is_told_beside_the_score(task: Path, poses: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["score", str(task), str(poses), "--metric", "ocrtoc2021"]) == 1
    said = capsys.readouterr().out
    assert "mean 5.00 cm; doing nothing 0.00 cm; mean bound 67.08 cm" in said
    assert "at the goal of b" in said
    assert main(["score", str(task), str(poses), "--metric", "ocrtoc2024"]) == 1
    assert "objects by overlap: 50% over 0.5, 50% over 0.6" in capsys.readouterr().out
    assert main(["score", str(task), str(poses), "--metric", "ocrtoc2024", "--json", "-"]) == 1
    data = json.loads(capsys.readouterr().out)
    assert data["ede_m"] == pytest.approx((0.3 + 0.3) / 2)
    assert (data["metric"], data["ocrtoc2024"]["error"]) == ("ocrtoc2024", 0.5)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["{task}", "{poses}", "--metric", "add"], "unknown metric 'add'; valid are ede,"),
        (["{task}"], "score needs TASK.yaml and POSES.json, or --leaderboard"),
        (["--leaderboard", "{folder}"], "holds no results.jsonl"),
        (["--leaderboard", "{empty}"], "there are no results in "),
        (["{task}", "--leaderboard", "{folder}"], "give the set of tasks by --tasks"),
        (["--leaderboard", "{folder}", "--metric", "ocrtoc2021"], "ranks by the metric ede"),
        (["--leaderboard", "{folder}", "{folder}"], "names a folder twice"),
    ],
)
def test_a_mistake_is_one_sentence(
    task: Path, poses: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], said: str
) -> None:
    empty = _folder(task.parent / "empty")
    filled = [a.format(task=task, poses=poses, folder=task.parent, empty=empty) for a in arguments]
    assert main(["score", *filled]) == 2
    output = capsys.readouterr()
    assert said in output.err
    assert output.err.count("\n") == 1


def _folder(folder: Path, *results: Result) -> str:
    folder.mkdir(parents=True)
    (folder / "results.jsonl").write_text("".join(to_json(r) + "\n" for r in results), encoding="utf-8")
    return str(folder)


def test_of_two_simulators_the_better_one_counts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = {"a": (0.01, 0.2), "b": (0.04, 0.05)}
    folders = []
    for simulator, errors in names.items():
        runs = [
            Result(f"task{i}", 0, "failed", ede_m=error, do_nothing_ede_m=0.3, mean_ueb_m=0.3, simulator=simulator)
            for i, error in enumerate(errors)
        ]
        folders.append(_folder(tmp_path / simulator, *runs))
    for more, error in ([], "7.50"), (["--best-of", "1"], "4.50"):
        assert main(["score", "--leaderboard", "+".join(folders), *more]) == 0
        assert capsys.readouterr().out.splitlines()[1].split()[:3] == ["1", "a+b", error]


def test_a_leaderboard_ranks_results_folders(tmp_path: Path, task: Path, capsys: pytest.CaptureFixture[str]) -> None:
    baselines = {"do_nothing_ede_m": 0.3, "mean_ueb_m": 0.3, "level": 2}
    good = _folder(tmp_path / "good", Result("pair", 0, "solved", ede_m=0.01, execution_sim_s=8.0, **baselines))
    killed = _folder(tmp_path / "killed", Result("pair", 0, "error"), Result("other", 0, "error"))
    written = tmp_path / "board.json"
    for more in ([], ["--tasks", str(task)]):
        assert main(["score", "--leaderboard", killed, good, "--json", str(written), *more]) == 0
        output = capsys.readouterr()
        lines = output.out.splitlines()
        assert lines[0].split()[:2] == ["rank", "solution"]
        assert [line.split()[:2] for line in lines[1:]] == [["1", "good"], ["2", "killed"]]
        assert lines[0].endswith("level 2")
        assert "left out other" in output.err
        best, worst = json.loads(written.read_text(encoding="utf-8"))
        assert (best["mean"]["error_m"], best["solved"]) == (0.01, 1)
        assert (worst["mean"]["improvement"], worst["attempted"]) == (0.0, 0)


def test_what_is_as_good_as_nothing_has_no_sign(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    same = Result("pair", 0, "failed", ede_m=0.30001, do_nothing_ede_m=0.3, mean_ueb_m=0.30001, level=1)
    assert main(["score", "--leaderboard", _folder(tmp_path / "idle", same)]) == 0
    output = capsys.readouterr().out
    assert output.count(" 0.0%") == 2 and "(0.0%)" in output and "-0" not in output
