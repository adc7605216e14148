"""`tamp samplers`, `tamp samplers check`, `tamp domains`, `tamp robots`: for people, and as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tamp.cli import main

ONE = Path(__file__).parents[2] / "scenarios" / "one_object.yaml"


def test_streams_are_listed_with_types_and_the_sampler_in_use(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    task = tmp_path / "task.yaml"
    task.write_text(ONE.read_text(encoding="utf-8") + "samplers: {sample-placement: theirs.places:near}\n", "utf-8")
    asked = ["--task", str(task), "--sampler", "sample-grasp=mine:grasps"]
    with pytest.raises(SystemExit):
        main(["samplers", "--nonsense"])
    assert main(["samplers"]) == 0
    listed = capsys.readouterr().out
    assert "inverse-kinematics(?o: str, ?p: Placement, ?g: Grasp) -> ?a: Configuration" in listed
    assert "tamp.streams.grasping.sampler:sample_grasp  (by the domain)" in listed
    (tmp_path / "mine.py").write_text("def grasps(context, obj): yield\n", encoding="utf-8")
    assert main(["samplers", *asked]) == 2, "an address that leads nowhere is said at once"


@pytest.mark.parametrize("command", ["robots", "domains", "samplers"])
def test_what_is_listed_is_also_data(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--json", "-"]) == 0
    listed = json.loads(capsys.readouterr().out)
    at_hand = [row for row in listed if "airo_models" not in row.get("error", "")]  # an extra, with a robot of its own
    said = {"robots": "joints", "domains": "actions", "samplers": "given_by"}[command]
    assert at_hand
    assert all(said in row for row in at_hand)


def test_the_kit_speaks_by_exit_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "judgement.json"
    ours = "tamp.streams.grasping.sampler:sample_grasp"
    own = ["samplers", "check", ours, "--stream", "sample-grasp", "--task", str(ONE)]
    assert main([*own, "--json", str(out)]) == 0
    assert "it fits" in capsys.readouterr().out
    assert json.loads(out.read_text(encoding="utf-8"))["fits"] is True
    bad = ["samplers", "check", "tests.pipeline.samplers:no_grasp", "--stream", "sample-grasp", "--task", str(ONE)]
    assert main(bad) == 1
    assert "it said: nobody grasps red" in capsys.readouterr().out
    assert main(["samplers", "check", "no.such:thing", "--stream", "sample-grasp"]) == 2
