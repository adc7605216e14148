"""The results of batches: each is written exactly once, none is lost in silence, and what is missing is run."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from tamp.batch import RESULTS, Batch, run_together
from tamp.errors import TampError
from tamp.results import read_results
from tamp.task import Task
from tests.batch.batches import WORK, run_batch, tasks_named


def test_resuming_runs_what_is_missing_exactly_once(tmp_path: Path) -> None:
    ran = tmp_path / "ran"
    out = tmp_path / "out"
    options = {"ran": str(ran)}
    first = run_batch("a", "b", options=options, output=out)
    torn = (out / RESULTS).read_bytes() + b'{"task": "c", "se'
    (out / RESULTS).write_bytes(torn)
    both = run_batch("a", "b", "c", options=options, output=out, resume=True, seeds=(0, 1))
    again = Batch(tasks_named("a", "b", "d"), options=options, work=WORK, output=out, resume=True)
    assert [(done.result.task, done.kept) for done in run_together([again])] == [("a", True), ("b", True), ("d", False)]
    assert len(first) == 2
    assert len(both) == 6
    assert sorted(ran.read_text(encoding="utf-8").split()) == ["a:0", "a:1", "b:0", "b:1", "c:0", "c:1", "d:0"]
    assert {(r.task, r.seed) for r in read_results(out / RESULTS)} == {*both, ("d", 0)}


def test_results_are_never_lost_in_silence(tmp_path: Path) -> None:
    run_batch("a", "b", output=tmp_path)
    before = (tmp_path / RESULTS).read_bytes() + b'{"torn'
    (tmp_path / RESULTS).write_bytes(before)
    with pytest.raises(TampError, match=r"already: --resume runs what is missing; --overwrite .* nothing was touched"):
        run_batch("a", output=tmp_path)
    with pytest.raises(
        TampError, match=r"what is missing, and again what was made otherwise: sleep \(1\); --overwrite"
    ):
        run_batch("a", output=tmp_path, options={"sleep": 0.1})
    assert (tmp_path / RESULTS).read_bytes() == before
    run_batch("a", output=tmp_path, overwrite=True)
    assert len(read_results(tmp_path / RESULTS)) == 1


def test_a_run_folder_without_results_is_kept_too(tmp_path: Path) -> None:
    (tmp_path / "a-0").mkdir()
    with pytest.raises(TampError, match="a-0 has results already"):
        run_batch("a", output=tmp_path)


@pytest.mark.parametrize("what", ["an option", "the task", "a version", "code"])
def test_what_was_made_otherwise_is_run_again(
    tmp_path: Path, what: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    ran, file = tmp_path / "ran", tmp_path / "a.yaml"
    file.write_text("objects: []", encoding="utf-8")
    (tmp_path / "own_search_of_a_batch.py").write_text("", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    task = Task("a", (), path=file, search="own_search_of_a_batch:find")

    def run(**options: Any) -> None:
        bounds: dict[str, Any] = {"output": tmp_path / "out", "resume": True, "work": WORK}
        results = list(Batch([task], options={"ran": str(ran), **options}, **bounds).run())
        assert len(results) == len(read_results(tmp_path / "out" / RESULTS)) == 1

    run(sleep=0.0)
    run(sleep=0.0)
    assert ran.read_text(encoding="utf-8").split() == ["a:0"]
    if what == "the task":
        file.write_text("objects: [] # another", encoding="utf-8")
    if what == "a version":
        monkeypatch.setattr("tamp.batch.run.versions", lambda: {"numpy": "0.1"})
    if what == "code":
        (tmp_path / "own_search_of_a_batch.py").write_text("edited = True", encoding="utf-8")
    run(sleep=0.1 if what == "an option" else 0.0)
    assert ran.read_text(encoding="utf-8").split() == ["a:0", "a:0"]
    assert "made otherwise and run again: 1 of 1 results; what differs:" in caplog.text
    told = {"an option": "sleep", "the task": "the task", "a version": "numpy", "code": "code of your own"}
    assert told[what] in caplog.text


def test_files_have_the_mode_that_the_umask_says(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        run_batch("a", output=tmp_path)
        run_batch("a", output=tmp_path, overwrite=True)
    finally:
        os.umask(before)
    assert (tmp_path / RESULTS).stat().st_mode & 0o777 == 0o640


def test_batches_run_by_turns_and_each_is_first_as_often(tmp_path: Path) -> None:
    ran = tmp_path / "ran"
    tasks = tasks_named("ok_1", "ok_2", "ok_3", "ok_4")
    both = [Batch(tasks, options={"ran": str(ran), "as": who}, output=tmp_path / who, work=WORK) for who in ("a", "b")]
    found = [(done.place, done.result.task) for done in run_together(both)]
    assert [task for _, task in found] == [name for i in range(1, 5) for name in (f"ok_{i}",) * 2]
    assert [place for place, _ in found[::2]] == [0, 1, 0, 1]
    for who in ("a", "b"):
        made = read_results(tmp_path / who / RESULTS)
        assert {r.configuration["as"] for r in made} == {who}
        assert len(made) == 4
    with pytest.raises(TampError, match="has results already"):
        list(run_together([Batch(tasks, output=tmp_path / "c", work=WORK), both[1]]))
    assert not (tmp_path / "c").exists(), "nothing is touched"


def test_two_batches_do_not_share_a_results_file(tmp_path: Path) -> None:
    first = Batch(tasks_named("a", "b"), output=tmp_path, work=WORK).run()
    next(first)
    with pytest.raises(TampError, match="another batch"):
        next(Batch(tasks_named("a"), output=tmp_path, work=WORK, overwrite=True).run())
    assert len(read_results(tmp_path / RESULTS)) == 1
    first.close()


def test_a_full_disk_is_reported_and_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = Batch(tasks_named("a", "b"), output=tmp_path, work=WORK).run()
    next(runs)
    write = os.write
    monkeypatch.setattr(os, "write", lambda fd, data: write(fd, data[:10]) if b"task" in data[:10] else write(fd, data))
    with pytest.raises(TampError, match="the disk is full; the results before this one are kept"):
        next(runs)
    assert [r.task for r in read_results(tmp_path / RESULTS)] == ["a"]


def test_a_job_that_finds_the_disk_full_ends_the_batch_and_can_run_later(tmp_path: Path) -> None:
    with pytest.raises(TampError, match="No space left on device; the results before"):
        run_batch("ok_1", "full", "ok_2", output=tmp_path)
    assert [result.task for result in read_results(tmp_path / RESULTS)] == ["ok_1"]


def test_tasks_of_the_same_name_are_refused() -> None:
    with pytest.raises(TampError, match=r"names must differ: a\.yaml and a\.yaml both are 'a'"):
        Batch(tasks_named("a", "a"))


def test_results_are_not_written_through_a_link(tmp_path: Path) -> None:
    mine = tmp_path / "mine.txt"
    mine.write_text("a line without an end")
    output = tmp_path / "theirs"
    output.mkdir()
    (output / RESULTS).symlink_to(mine)
    with pytest.raises(TampError, match="it is a link; choose another --output"):
        list(Batch(tasks_named("a"), work=WORK, output=output, resume=True).run())
    assert mine.read_text() == "a line without an end"


def test_a_pipe_in_place_of_results_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / RESULTS)
    with pytest.raises(TampError, match="it is no regular file; choose another --output"):
        list(Batch(tasks_named("a"), work=WORK, output=tmp_path, resume=True).run())


def test_an_unwritable_output_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(TampError, match="cannot be written"):
        next(Batch(tasks_named("a"), output=tmp_path / "file", work=WORK).run())
