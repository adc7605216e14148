"""contest.yaml: the paper's rules where it says nothing, and one clear sentence where it is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamp.cli import main, parser
from tamp.contest.rules import Rules, load_rules, read_rules, task_files
from tamp.contest.sandbox.runtime import closure
from tamp.errors import TampError


def test_an_empty_file_has_the_papers_rules() -> None:
    rules = read_rules("")
    assert rules == Rules()
    assert (rules.runs, rules.execution_s) == (3, 600.0)
    assert (rules.best_of_runs, rules.best_of_simulators) == ("task", "solution")


def test_every_setting_is_read() -> None:
    rules = read_rules(
        "name: cup\nsimulators: [mujoco]\nruns: 2\nbest_of_runs: mean\nlimits: {memory_mb: 100}\n"
        "uploads: {a_month: 1}\nreveal: true\nseed: 0\nexecution_s: 30\nlibraries: [scipy]\n"
    )
    assert (rules.name, rules.simulators, rules.runs, rules.best_of_runs) == ("cup", ("mujoco",), 2, "mean")
    assert (rules.limits.memory_mb, rules.uploads.a_month, rules.reveal, rules.libraries) == (100, 1, True, ("scipy",))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("rums: 3", r"contest.yaml:1: rums: unknown; did you mean .runs.. valid are name"),
        ("\nruns: 0", r"contest.yaml:2: runs: expected a whole number of at least 1"),
        ("runs: 1.5", "whole number"),
        ("runs: true", "whole number"),
        ("execution_s: -1", "positive number"),
        ("execution_s: .nan", "positive number"),
        ("runs: 2000000000", "at least 1 and at most 1000"),
        ("seed: 9999999999", "at least 0 and at most 2147483648"),
        ("limits: {wall_s: 1e10}", "at least 0.001 and at most 1e[+]09"),
        ("simulators: [mujoco, mujoco]", "one stands twice; say with 'runs' how often"),
        ("best_of_runs: best", "valid are task, solution, mean"),
        ("renderer: crayon", "'crayon' is not valid; valid are raycast, software"),
        ("limits: {cpu: 1}", "limits.cpu: unknown"),
        ("limits: 3", "limits: expected a mapping"),
        ("simulators: pybullet", "expected a list"),
        ("simulators: []", "at least one"),
        ("name: [x]", "expected text"),
        ("reveal: 1", "true or false"),
        ("- 1", "expected a mapping"),
        ("path: /etc", "unknown"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(text: str, complaint: str) -> None:
    with pytest.raises(TampError, match=complaint):
        read_rules(text)


def test_tasks_are_found_beside_the_file(tmp_path: Path) -> None:
    (tmp_path / "tasks").mkdir()
    (tmp_path / "tasks" / "a.yaml").write_text("")
    (tmp_path / "contest.yaml").write_text("contest: [tasks/*.yaml]\ntrial: [none/*.yaml]\n")
    rules = load_rules(tmp_path / "contest.yaml")
    assert task_files(rules, "contest") == (tmp_path / "tasks" / "a.yaml",)
    with pytest.raises(TampError, match=r"no file 'none/\*.yaml'"):
        task_files(rules, "trial")


@pytest.mark.parametrize("pattern", ["**.yaml", "."])
def test_what_is_no_pattern_is_said(pattern: str, tmp_path: Path) -> None:
    (tmp_path / "contest.yaml").write_text(f"contest: ['{pattern}']\n")
    with pytest.raises(TampError, match="is no pattern of files, such as"):
        task_files(load_rules(tmp_path / "contest.yaml"), "contest")


def test_a_library_is_a_name_without_a_version() -> None:
    for name in ("numpy>=1", "[extra]"):
        with pytest.raises(TampError, match="expected the name of a distribution, without a version"):
            closure((name,))


def test_a_new_contest_has_rules_trial_tasks_and_a_seed_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("club", "other"):
        assert main(["contest", "new", str(tmp_path / name)]) == 0
    club, other = (load_rules(tmp_path / name / "contest.yaml") for name in ("club", "other"))
    assert (club.name, club.runs, len(task_files(club, "trial"))) == ("club", 3, 5)
    assert club.seed != other.seed
    told = [line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("  tamp ")]
    assert [words[1:3] for words in told] == [["generate", "-n"], ["contest", "team"], ["contest", "serve"]] * 2
    assert str(parser().parse_args(told[-1][1:]).data) == str(tmp_path / "other")
    assert main(["contest", "new", str(tmp_path / "club")]) == 2
    assert "exists already; nothing was changed" in capsys.readouterr().err
