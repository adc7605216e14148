"""The report: one file that says everything, with no network, and that a browser shows without a complaint."""

from __future__ import annotations

import csv
import importlib.util
import re
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import tamp
from tamp.cli import main, parser
from tamp.errors import TampError
from tamp.perception.belief.belief import Belief
from tamp.perception.estimate import Estimate
from tamp.pipeline.perceived.run import Look
from tamp.pipeline.solving.run import Run, save_run
from tamp.report.reasons import reasons
from tamp.report.rendering.playback import play, playable
from tamp.report.report import REST, _phases
from tamp.report.runs import Recorded, read_run, read_runs
from tamp.report.tables import csv_text, summary_line
from tamp.report.viewer import Viewer
from tamp.results import Result, to_json
from tamp.task import Mesh, Object, Pose, Task
from tests.browser import look, needs_chromium

FAILED = Result(
    "hard", 1, "failed", message="goals not reached: mug; mug left: hand would hit jar at 0.31 m", ede_m=0.3,
    do_nothing_ede_m=0.3, mean_ueb_m=0.6, improvement=0.0,
    objects=({"name": "mug", "ede_m": 0.3, "ueb_m": 0.6, "error_m": 0.3},), goals_met={"mug": False, "jar": True},
)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory, run, one_object):
    """One solved run with all its files, and one failed run of which only the result is left."""
    folder = tmp_path_factory.mktemp("results")
    save_run(run, one_object, {"seed": 0}, folder / "one_object-0")
    lines = [to_json(run.result), to_json(FAILED)]
    (folder / "results.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def page(folder) -> str:
    assert main(["report", str(folder)]) == 0
    return (folder / "report.html").read_text(encoding="utf-8")


def test_the_page_stands_alone(page: str) -> None:
    assert set(re.findall(r"https?://[^/\"]+", page)) <= {"http://www.w3.org"}, "names of formats only"
    assert not re.search(r"<(script|link rel=\"stylesheet\")", page)
    assert page.count("data:image/jpeg;base64,") == 3


@pytest.mark.parametrize(
    "said",
    ["Leaderboard", "Solved over planning time", "Error by level", "Error by object", "Time in each stream", "Why runs",
     "pick red from table", "place red on table, at (5.0, -20.0, ", "an object left: hand would hit an object at # m"],
)  # fmt: skip
def test_the_page_says_everything(page: str, said: str) -> None:
    assert said in page


@needs_chromium
def test_a_browser_shows_it(folder: Path, page: str, tmp_path: Path) -> None:
    assert look((folder / "report.html").as_uri(), tmp_path / "page.png", size=(1200, 3000)) == []
    shown = np.asarray(Image.open(tmp_path / "page.png").convert("RGB"), int) @ (65536, 256, 1)
    assert len(np.unique(shown)) > 1500, "plots and pictures are there"


def test_searches_in_vain_count_where_time_goes(tmp_path: Path, run: Run, one_object: Task) -> None:
    vain = replace(run.searches[0], status="failed", seconds={"search": 7.0}, streams=())
    save_run(replace(run, searches=(*run.searches, vain)), one_object, {"seed": 0}, tmp_path)
    alone = dict(run.searches[0].seconds)
    assert read_run(tmp_path).phase_seconds == {**alone, "search": alone.get("search", 0.0) + 7.0}


BROKEN = [
    "{}",
    "3",
    "[1]",
    "no json",
    '[{"seconds": 3, "streams": []}]',
    '[{"seconds": {"search": "?"}, "streams": []}]',
]


@pytest.mark.parametrize("text", BROKEN)
def test_of_a_broken_record_of_searches_the_plans_tell(
    tmp_path: Path, run: Run, one_object: Task, text: str, caplog: pytest.LogCaptureFixture
) -> None:
    save_run(run, one_object, {"seed": 0}, tmp_path)
    (tmp_path / "searches.json").write_text(text, encoding="utf-8")
    assert read_run(tmp_path).phase_seconds == run.plans[0].report["seconds"]
    assert "searches.json: left out" in caplog.text


def test_a_folder_without_results_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path)]) == 2
    assert "there are no results in it" in capsys.readouterr().err


def test_what_is_no_folder_is_called_that(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path / "nowhere")]) == 2
    assert "there is no such folder" in capsys.readouterr().err


def test_each_contender_is_told_apart_and_each_task(tmp_path: Path) -> None:
    """Two folders, two tasks that both have a mug; statuses that can be filtered; links and commands to go on with."""
    for name, shift in (("ours", 0.0), ("theirs", 0.1)):
        made = [
            Result(task, 0, status, planning_s=2.0, ede_m=0.1 + shift, message="" if status == "solved" else f"{name}!",
                   objects=({"name": "mug", "ede_m": 0.1 + shift, "ueb_m": 0.6, "error_m": 0.1},), level=1,
                   task_path=f"tasks/{task}.yaml", do_nothing_ede_m=0.3, mean_ueb_m=0.6,
                   configuration={"samplers": {"sample-grasp": "a:b"}, "timeout": 9.0, "execute": False})
            for task, status in (("shelf", "solved"), ("desk", "failed"))
        ]  # fmt: skip
        (tmp_path / name / "shelf-0").mkdir(parents=True)
        for film in ("run.gif", "run.mp4"):
            (tmp_path / name / "shelf-0" / film).write_bytes(b"")
        lines = [to_json(result) + "\n" for result in made]
        (tmp_path / name / "results.jsonl").write_text("".join(lines), encoding="utf-8")
    assert main(["report", str(tmp_path / "ours"), str(tmp_path / "theirs")]) == 0
    page = (tmp_path / "ours" / "report.html").read_text(encoding="utf-8")
    for said in ("mug in shelf", "mug in desk", "level 1, ours", "level 1, theirs", "ours!", "theirs!", REST):
        assert said in page, said
    assert page.count("<h3>theirs</h3>") == 3, "objects, reasons, runs"
    assert 'href="shelf-0"' in page
    assert 'href="../theirs/shelf-0/run.gif"' in page
    assert '<img loading="lazy" src="../theirs/shelf-0/run.gif"' in page
    assert 'src="../theirs/shelf-0/run.mp4"></video>' in page
    again = "tamp solve tasks/desk.yaml --seed 0 --sampler sample-grasp=a:b --timeout 9.0 --no-execute"
    assert again in page
    assert parser().parse_args(again.split()[1:]).timeout == 9.0
    assert 'id="show-failed"' in page


def test_a_run_whose_mesh_cannot_be_used_any_more_is_told_without_pictures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "ball.obj").write_text("no mesh\n", encoding="utf-8")
    task = Task("rolls", (Object("ball", Mesh(tmp_path / "ball.obj"), Pose((0.1, 0.0, 0.03))),))
    tamp.save_task(task, tmp_path / "rolls.yaml")
    line = to_json(Result("rolls", 0, "failed", task_path=str(tmp_path / "rolls.yaml"))) + "\n"
    (tmp_path / "results.jsonl").write_text(line, encoding="utf-8")
    assert main(["report", str(tmp_path)]) == 0
    said = capsys.readouterr().err
    assert "no pictures" in said
    assert "ball.obj: the mesh has no faces" in said


@given(st.floats(0.5, 9.0), st.dictionaries(st.sampled_from(["search", "binding"]), st.floats(0.0, 0.2)))
def test_where_planning_time_goes_adds_up(planning_s: float, told: dict[str, float]) -> None:
    run = Recorded(Result("a", 0, "solved", planning_s=planning_s), Path("nowhere"))
    run.__dict__["plans"] = (SimpleNamespace(report={"seconds": told}),)
    assert sum(_phases([run]).values()) == pytest.approx(planning_s)


def test_names_are_escaped(tmp_path: Path) -> None:
    # A name of a folder's, which has no slash.
    result = Result("<img src=x onerror=alert(1)>", 0, "failed", message="<script>alert(1)</script>")
    (tmp_path / "results.jsonl").write_text(to_json(result) + "\n", encoding="utf-8")
    assert main(["report", str(tmp_path)]) == 0
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<img src=x" not in page
    assert "<script>alert" not in page


def test_a_plan_reads_as_a_list(run, one_object, tmp_path) -> None:
    save_run(run, one_object, {}, tmp_path)
    ((pick, place),) = read_run(tmp_path).told
    assert re.fullmatch(r"pick red from table \(\d+\.\d s\)", pick)
    assert re.fullmatch(r"place red on table, at \(5\.0, -20\.0, 4\.\d\) cm \(\d+\.\d s\)", place)


@pytest.mark.parametrize("text", ["{}", "[3]", "[[3]]", "no json"])
def test_of_broken_words_the_plans_tell(run, one_object, tmp_path, text: str, caplog) -> None:
    save_run(run, one_object, {}, tmp_path)
    (tmp_path / "actions.json").write_text(text, encoding="utf-8")
    assert read_run(tmp_path).told == (("move()", "pick(red, table)", "move(red)", "place(red, table)"),)
    assert "actions.json: left out" in caplog.text


def test_reasons_are_counted_without_names_and_numbers() -> None:
    again = Result("other", 0, "timeout")
    assert reasons([FAILED, FAILED, again])[:2] == [
        ("an object left: hand would hit an object at # m", 2),
        ("goals not reached", 2),
    ]
    assert ("timeout", 1) in reasons([again])
    unlisted = Result(
        "planned", 0, "timeout", message="no plan (timeout); cup_2: no time was left; mug-1: no time was left"
    )
    assert reasons([unlisted]) == [("an object: no time was left", 1), ("no plan (timeout)", 1)]
    assert reasons([Result("bug", 0, "error", message="ValueError: a bug")]) == [("ValueError: a bug", 1)]
    meant = "no stream 'a'; did you mean 'b'? the domain has b"
    assert reasons([Result("typo", 0, "invalid", message=meant)]) == [(meant, 1)]


def test_results_as_a_table_and_as_a_line() -> None:
    head, row = csv_text([FAILED]).splitlines()
    assert head.startswith("task,seed,status")
    assert row.startswith("hard,1,failed")
    met = Result("a", 0, "failed", goals_met={"red": True, "blue": False}, remarks=("one", "two"))
    (cells,) = csv.DictReader(csv_text([met]).splitlines())
    assert (cells["goals_met"], cells["remarks"]) == ("red: met; blue: not met", "one; two")
    assert "()" not in row
    line = summary_line([FAILED, Result("a", 0, "solved")])
    assert line.startswith("summary: total=2 solved=1 planned=0 failed=1 ")
    assert dict(pair.split("=") for pair in line.split()[1:])["mean_ede_m"] == "0.3"


@pytest.fixture
def perceived(tmp_path: Path, run, one_object) -> Path:
    """A results folder of a run in which poses were perceived."""
    name = one_object.objects[0].name
    told = {
        "name": name,
        "fate": "reached",
        "estimate_m": 0.0021,
        "raw_m": 0.05,
        "confidence": 0.9,
        "look": 0,
        "end_m": 0.01,
    }
    lost = {
        "name": "mug",
        "fate": "not seen",
        "estimate_m": None,
        "raw_m": None,
        "confidence": 0.0,
        "look": None,
        "end_m": 0.4,
    }
    result = replace(run.result, perceived=True, perception=({**told, "end_m": 0.01}, {**lost, "end_m": 0.4}))
    there, away = Pose((0.1, 0.2, 0.04)), Pose((0.1, 0.23, 0.04))
    picture = np.full((4, 6, 3), 200, dtype=np.uint8)
    look = Look(
        Belief({name: Estimate(there, 0.9), "mug": Estimate(None, 0.0)}),
        {name: away, "mug": away},
        {name: 0.05},
        {"00-kinect": picture},
    )
    folder = tmp_path / "results"
    save_run(replace(run, result=result, looks=(look,)), one_object, {"seed": 0}, folder / "one_object-0")
    (folder / "results.jsonl").write_text(to_json(result) + "\n", encoding="utf-8")
    return folder


def test_what_was_seen_is_in_the_page_and_in_the_record(perceived: Path) -> None:
    assert main(["report", str(perceived)]) == 0
    page = (perceived / "report.html").read_text(encoding="utf-8")
    assert "look 0, 00-kinect" in page
    assert re.search(r"reached</td>\s*<td>0</td><td>0.21</td><td>5.00</td><td>90", page)
    assert re.search(r"not seen</td>\s*<td>–</td><td>–</td>", page)
    (sight,) = read_run(perceived / "one_object-0").sights
    assert (len(sight.estimates), len(sight.truth), len(sight.pictures)) == (1, 2, 1)
    assert list(sight.errors.values()) == [0.05]


@pytest.mark.skipif(importlib.util.find_spec("viser") is None, reason="the extra 'viewer' is missing")
def test_the_viewer_shows_what_was_seen(perceived: Path, tmp_path: Path) -> None:
    assert main(["view", str(perceived / "one_object-0"), "--port", "0", "--record", str(tmp_path / "a.html")]) == 0
    text = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert len(text) > 10_000
    run = read_run(perceived / "one_object-0")
    viewer = Viewer(playable(run), run.plans[0].goals, play(run, 1.0), port=0, sights=run.sights)
    labels = [h.text for h in viewer.server.scene._handle_from_node_name.values() if hasattr(h, "text")]
    viewer.close()
    assert labels == [f"{next(iter(run.sights[0].estimates))}: 5.0 cm off, 90% sure"], (
        "turns count, not how far apart origins are"
    )


def test_a_record_of_a_look_that_is_none_is_said(perceived: Path) -> None:
    (perceived / "one_object-0" / "look-0.details.json").write_text("[]", encoding="utf-8")
    with pytest.raises(TampError, match=r"look-0\.details\.json: not the record of a look"):
        _ = read_run(perceived / "one_object-0").sights


def test_links_in_a_stranger_s_folder_lead_nothing_out_of_it(tmp_path, folder, run, one_object):
    theirs, mine = tmp_path / "theirs", tmp_path / "mine.txt"
    shutil.copytree(folder, theirs)
    mine.write_text("mine")
    places = [theirs / "report.html", theirs / "one_object-0" / "result.json", theirs / "one_object-0" / "report.txt"]
    for place in places:
        place.unlink(missing_ok=True)
        place.symlink_to(mine)
    save_run(run, one_object, {"seed": 0}, theirs / "one_object-0")
    assert main(["report", str(theirs)]) == 0
    assert mine.read_text() == "mine"
    assert all(place.is_file() and not place.is_symlink() for place in places)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_page_for_which_there_is_no_room_is_named(folder, capsys):
    assert main(["report", str(folder), "--pictures", "0", "-o", "/dev/full"]) == 2
    assert capsys.readouterr().err == "tamp: /dev/full: No space left on device\n"


@pytest.mark.parametrize("name", ["../elsewhere", "/tmp/elsewhere"])
def test_runs_of_another_folder_are_not_read(tmp_path, name):
    line = to_json(replace(FAILED, task=name))
    (tmp_path / "results.jsonl").write_text(line + "\n", encoding="utf-8")
    with pytest.raises(TampError, match="is no name of a task"):
        read_runs(tmp_path)
