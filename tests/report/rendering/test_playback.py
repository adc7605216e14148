"""A run is played back, rendered and viewed."""

from __future__ import annotations

import importlib.util
import shutil
import urllib.request
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tamp.cli import main
from tamp.pipeline.solving.run import save_run
from tamp.pipeline.solving.solve import Run
from tamp.report.rendering.images import save_animation
from tamp.report.rendering.playback import play, simulate
from tamp.report.runs import read_run
from tamp.task import Action, Move, Plan, Pose, Task, Trajectory
from tamp.task.files.plan_file import load_plan, save_plan
from tests.browser import needs_chromium, watch

needs_viser = pytest.mark.skipif(importlib.util.find_spec("viser") is None, reason="the extra 'viewer' is missing")
needs_ffmpeg = pytest.mark.skipif(
    importlib.util.find_spec("imageio_ffmpeg") is None, reason="the extra 'video' is missing"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, run: Run, one_object: Task) -> Path:
    folder = tmp_path_factory.mktemp("run") / "one_object-0"
    save_run(run, one_object, {"seed": 0}, folder)
    return folder


def test_a_plan_is_played_from_start_to_end(folder: Path, run: Run) -> None:
    moments = play(read_run(folder), 0.2)
    times = [moment.frame.time for moment in moments]
    assert times == sorted(times)
    assert moments[0].frame.poses == run.plans[0].start
    assert moments[-1].frame.poses == dict(run.final_poses)
    assert list(dict.fromkeys(m.action for m in moments)) == [
        "start", "move()", "pick(red, table)", "move(red)", "place(red, table)", "solved",
    ]  # fmt: skip
    highest = max(moment.frame.poses["red"].xyz[2] for moment in moments)
    assert highest > 0.07, "it is carried, not pushed"
    meant = moments[-2].frame.poses["red"].xyz
    assert np.linalg.norm(np.subtract(meant, run.plans[0].goals["red"].xyz)) < 1e-3


def test_playing_and_simulating_tell_the_same_story(folder: Path) -> None:
    played, simulated = play(read_run(folder), 0.5), simulate(read_run(folder), 0.5)
    ends = [moments[-1].frame.poses["red"].xyz for moments in (played, simulated)]
    assert np.linalg.norm(np.subtract(*ends)) < 5e-3
    assert "place(red, table)" in {moment.action for moment in simulated}


def test_pictures_and_a_film_are_written(folder: Path, tmp_path: Path) -> None:
    assert main(["render", str(folder), "-o", str(tmp_path), "--frame", "2"]) == 0
    start, end = (np.asarray(Image.open(tmp_path / f"{name}.png"), int) for name in ("start", "end"))
    assert start.shape == end.shape
    assert np.abs(start - end).sum() > 0
    assert (tmp_path / "run.gif").stat().st_size > 5000


@needs_ffmpeg
def test_a_film_may_be_an_mp4(tmp_path: Path) -> None:
    images = [np.full((36, 64, 3), shade, np.uint8) for shade in (0, 80, 160, 240)]
    save_animation(images, tmp_path / "grey.mp4", frame_s=0.1)
    assert b"ftyp" in (tmp_path / "grey.mp4").read_bytes()[:12]


@needs_viser
@needs_chromium
def test_a_recording_plays_in_a_browser(folder: Path, tmp_path: Path) -> None:
    page = tmp_path / "run.html"
    assert main(["view", str(folder), "--record", str(page), "--port", "0", "--frame", "1"]) == 0

    def drawn(picture: Image.Image) -> bool:
        """Robot, table and block are there: beside viser's own signs, many shades."""
        shades = np.asarray(picture.convert("RGB"), int)[:420, 320:] @ (65536, 256, 1)
        return len(np.unique(shades)) > 100

    assert watch(page.as_uri(), tmp_path, drawn), "nothing was drawn"


@needs_viser
def test_the_viewer_answers_and_refuses_other_recordings(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from tamp.report.viewer import Viewer

    run = read_run(folder)
    assert run.task is not None
    viewer = Viewer(run.task, run.plans[0].goals, play(run, 1.0), port=0)
    try:
        with urllib.request.urlopen(f"http://localhost:{viewer.server.get_port()}", timeout=20) as answer:
            assert b"<html" in answer.read()
    finally:
        viewer.close()
    assert main(["view", str(folder), "--record", str(tmp_path / "a.mp4"), "--port", "0"]) == 2
    assert "a recording ends in .html" in capsys.readouterr().err


def test_what_cannot_be_played_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", str(tmp_path)]) == 2
    assert "not a run: there is no result.json" in capsys.readouterr().err
    assert main(["render", str(tmp_path / "none")]) == 2
    assert "there is no such folder" in capsys.readouterr().err
    (tmp_path / "swap-0").mkdir()
    (tmp_path / "swap-0" / "result.json").touch()
    assert main(["render", str(tmp_path)]) == 2
    assert f"name one of them, such as {tmp_path / 'swap-0'}" in capsys.readouterr().err


def test_a_plan_that_is_not_for_the_run_s_task_is_not_played(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As a stranger may send it: for another arm, about other objects, or one that takes a week."""
    run, edits = tmp_path / "one_object-0", dict[str, Callable[[Plan], Plan]]()
    shutil.copytree(folder, run)
    good = load_plan(run / "plan-0.json")
    edits["home has 6 values; the arm has 7 joints"] = lambda plan: replace(plan, home=plan.home[:6])
    edits["the plan is about 'ghost'"] = lambda plan: replace(plan, start={**plan.start, "ghost": Pose()})
    edits["does not say where red starts"] = lambda plan: replace(plan, start={})
    edits["moments are more than 100,000"] = lambda plan: replace(plan, actions=(waiting(plan),))
    for sentence, edit in edits.items():
        save_plan(edit(good), run / "plan-0.json")
        assert main(["render", str(run), "-o", str(tmp_path / "pictures")]) == 2
        assert sentence in capsys.readouterr().err


def waiting(plan: Plan) -> Action:
    """A week without a motion."""
    still = Trajectory(np.array([0.0, 604_800.0]), np.tile(plan.home, (2, 1)), np.zeros((2, 7)))
    return Action("move", (), (Move("transit", still, 0.08),))
