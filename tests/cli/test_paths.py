"""Where something is written: refused in one sentence before any work, and never over what something else wrote."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import pytest

from tamp.cli import main
from tamp.cli.paths import DATA, PAGE, PLAN, TABLE, distinct, output_file, output_folder, output_path

FORMS = {
    PLAN: '{"format":"tamp-plan","version":1}',
    DATA: '[{"task": "a"}]',
    TABLE: "task,seed\n",
    PAGE: "<!doctype html>",
}


@pytest.mark.parametrize("form", FORMS)
def test_a_file_is_replaced_by_its_like_alone(tmp_path: Path, form: tuple[str, str]) -> None:
    path = tmp_path / "there"
    assert output_file(form)(str(path)) == path, "nothing is there"
    for text in ("", FORMS[form]):
        path.write_text(text, encoding="utf-8")
        assert output_file(form)(str(path)) == path
    for text in ("name: tidy\nobjects: []\n", "{name: tidy, objects: []}"):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(argparse.ArgumentTypeError, match=f"is there already and is not {form[1]}"):
            output_file(form)(str(path))


def test_what_cannot_be_written_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    below = str(tmp_path / "file" / "below")
    for kind in (output_file(), output_folder, output_path):
        assert kind(str(tmp_path / "new" / "deep")) == tmp_path / "new" / "deep"
        for bad, why in ((below, "file is no folder"), ("x" * 300, "name too long")):
            with pytest.raises(argparse.ArgumentTypeError, match=f"(?i)cannot be written: .*{why}"):
                kind(bad)
    with pytest.raises(argparse.ArgumentTypeError, match="it is a folder"):
        output_file()(str(tmp_path))
    with pytest.raises(argparse.ArgumentTypeError, match="it is no folder"):
        output_folder(str(tmp_path / "file"))
    assert not (tmp_path / "new").exists()


def test_a_path_that_leads_where_an_earlier_one_does_is_left_out(tmp_path: Path) -> None:
    assert distinct([tmp_path / "a", tmp_path / "b", tmp_path / "b" / ".." / "a"]) == [tmp_path / "a", tmp_path / "b"]


@pytest.mark.parametrize(
    "command",
    [
        ["plan", "TASK", "-o", "TASK"], ["plan", "TASK", "-o", "TASK/plan.json"], ["plan", "TASK", "--json", "TASK/x"],
        ["execute", "TASK", "p.json", "-o", "TASK/x"], ["report", "runs", "-o", "TASK/r.html"],
        ["render", "runs/a-0", "-o", "TASK/x"], ["solve", "TASK", "--csv", "TASK"],
        ["solve", "TASK", "--output", "TASK"], ["compare", "TASK", "--output", "TASK/x"],
    ],
)  # fmt: skip
def test_every_command_looks_first(tmp_path: Path, command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    task = tmp_path / "task.yaml"
    task.write_text("not read", encoding="utf-8")
    with pytest.raises(SystemExit) as status:
        main([word.replace("TASK", str(task)) for word in command])
    said = capsys.readouterr().err
    assert (status.value.code, said.count("\n")) == (2, 1)
    assert "cannot be written" in said or "is there already" in said
    assert task.read_text(encoding="utf-8") == "not read"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_output_that_does_not_fit_is_one_sentence() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run([sys.executable, "-m", "tamp", "robots"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (2, "tamp: No space left on device\n")


def test_a_write_that_fails_all_the_same_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device", "page.html")

    monkeypatch.setattr("tamp.report.report.write_report", full)
    assert main(["report", str(tmp_path)]) == 2
    assert capsys.readouterr().err == "tamp: page.html: No space left on device\n"
