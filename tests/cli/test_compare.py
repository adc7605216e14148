"""`tamp compare`: two samplers over the same tasks; statistics that know how little few tasks say."""

from __future__ import annotations

import argparse
import json
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.cli import main
from tamp.cli.commands.results.compare import contender, unnamed
from tamp.report.comparison import compare
from tamp.report.statistics import mean, share
from tamp.results import Result, to_json

ONE = Path(__file__).parents[2] / "scenarios" / "one_object.yaml"


def results(shift: float, tasks: int = 8) -> list[Result]:
    return [
        Result(f"t{i}", seed, "solved", planning_s=1.0 + 0.1 * i + shift, ede_m=0.01, n_actions=4)
        for i in range(tasks)
        for seed in (0, 1)
    ]


def test_a_difference_is_told_from_chance() -> None:
    (slower,) = compare({"a": results(0.0), "b": results(0.5)})
    verdicts = {row.measure.name: row.verdict for row in slower.rows}
    assert slower.pairs == 16
    assert verdicts["planning [s], where both solve"] == "worse"
    assert verdicts["EDE [cm]"] == "no clear difference"
    (row,) = (row for row in slower.rows if row.measure.name.startswith("planning"))
    assert row.difference.mean == pytest.approx(0.5)
    assert row.difference.lower == pytest.approx(0.5), "paired: the tasks' own differences are no noise"


def test_perceivers_are_compared_by_what_they_see() -> None:
    def seen(*errors: float | None) -> list[Result]:
        rows = [{"name": f"o{i}", "estimate_m": error} for i, error in enumerate(errors)]
        return [replace(r, perceived=True, perceiving_s=3.0, perception=tuple(rows)) for r in results(0.0)]

    (comparison,) = compare({"a": seen(0.002, 0.004), "b": seen(0.01, None)})
    rows = {row.measure.name: row for row in comparison.rows}
    assert (rows["objects found [%]"].first.mean, rows["objects found [%]"].other.mean) == (100.0, 50.0)
    off = rows["estimates off [cm], where both find any"]
    assert (off.first.mean, off.other.mean, off.verdict) == (pytest.approx(0.3), pytest.approx(1.0), "worse")
    assert rows["perceiving [s]"].verdict == "no clear difference"
    (given_poses,) = compare({"a": results(0.0), "b": results(0.0)})
    assert sum(row.verdict == "nothing to compare" for row in given_poses.rows) == 4  # and no load was recorded


@pytest.mark.parametrize("tasks", [2, 5])
def test_what_may_be_chance_in_more_than_5_of_100_has_no_verdict(tasks: int) -> None:
    """That all of five tasks differ in one direction has a chance of 2 / 2^5, that all of six do 2 / 2^6."""
    (few,) = compare({"a": results(0.0, tasks), "b": results(9.0, tasks)})
    assert compare({"a": results(0.0, 6), "b": results(9.0, 6)})[0].rows[2].verdict == "worse"
    assert {row.verdict for row in few.rows if row.difference.count} == {"too few tasks"}
    assert json.dumps(few.as_dict(), allow_nan=False)


def test_only_what_both_have_run_is_compared() -> None:
    (comparison,) = compare({"a": results(0.0), "b": results(0.0)[:4]})
    assert comparison.pairs == 4


@given(st.integers(0, 40), st.integers(1, 40))
def test_wilsons_interval_holds_the_share_and_stays_in_bounds(successes: int, more: int) -> None:
    estimate = share(successes, successes + more)
    assert 0.0 <= estimate.lower <= estimate.mean <= estimate.upper <= 1.0
    assert math.isnan(share(0, 0).mean)


def test_the_bootstrap_repeats_and_covers() -> None:
    groups = {str(i): [float(i), i + 1.0] for i in range(10)}
    estimate = mean(groups)
    assert estimate == mean(dict(reversed(groups.items())))
    assert estimate.lower < estimate.mean == 5.0 < estimate.upper
    assert mean({}).count == 0


def test_the_command_compares_and_writes_its_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = "sample-grasp=tests.pipeline.samplers:from_above"
    arguments = ["compare", str(ONE), "--sampler", "default", "--sampler", mine, "--output", str(tmp_path)]
    data = tmp_path / "comparison.json"
    assert main([*arguments, "--no-execute", "--json", str(data)]) == 0
    assert f"{mine} against default" in capsys.readouterr().out
    (comparison,) = json.loads(data.read_text(encoding="utf-8"))
    assert (comparison["pairs"], comparison["measures"][0]["first"]["mean"]) == (1, 100.0)
    page = (tmp_path / "comparison.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 2
    assert set(re.findall(r"https?://[^/\"]+", page)) <= {"http://www.w3.org"}, "names of formats only, no network"


def test_what_broke_is_said_of_each_contender(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = "sample-grasp=tests.pipeline.bad_samplers:raises"
    arguments = ["compare", str(ONE), "--sampler", "default", "--sampler", broken, "--output", str(tmp_path)]
    assert main([*arguments, "--no-execute"]) == 1
    said = capsys.readouterr().out
    assert "default: 1 planned" in said
    assert f"{broken}: 1 error; 1 times: the sampler of stream 'sample-grasp' raised" in said
    assert "1 error" in (tmp_path / "comparison.html").read_text(encoding="utf-8")


def test_contenders_have_names_and_differ_in_samplers_and_settings() -> None:
    both = contender("mine:sample-grasp=a.b:c,algorithm=focused")
    assert (both.name, both.samplers, both.settings) == ("mine", {"sample-grasp": "a.b:c"}, {"algorithm": "focused"})
    assert contender("seer:perceive=my.eyes:look").settings == {"perceive": "my.eyes:look"}
    assert contender("ten:strategy=my.plans:TEN").settings == {"strategy": "my.plans:TEN"}
    assert contender("slow:carrying_speed=0.1,max_replans=0").settings == {
        "tuning": {"carrying_speed": 0.1, "max_replans": 0}
    }
    assert contender("plain").samplers == contender("plain").settings == {}
    assert unnamed("sample-grasp=a:b").name == "sample-grasp=a:b"
    for wrong, said in (
        ("sample-grasp=a:b", "has no name"),
        ("x:algorithm=magic", "valid are adaptive, binding, focused, incremental"),
        ("x:algorithm=bindin", "did you mean 'binding'"),
        ("x:stratgy=serialized", "did you mean 'strategy'"),
        ("x:sample-grasp=a", "valid are STREAM=MODULE:FUNCTION"),
        ("x:sample-grasp", "valid are STREAM=MODULE:FUNCTION"),
    ):
        with pytest.raises(argparse.ArgumentTypeError, match=said):
            contender(wrong)


def test_folders_of_results_are_compared_as_they_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, shift in (("fast", 0.0), ("slow", 0.5)):
        (tmp_path / name).mkdir()
        lines = [to_json(result) + "\n" for result in results(shift)]
        (tmp_path / name / "results.jsonl").write_text("".join(lines), encoding="utf-8")
    folders = [str(tmp_path / "fast"), str(tmp_path / "slow")]
    assert main(["compare", *folders, "--output", str(tmp_path / "out")]) == 0
    assert "slow against fast" in capsys.readouterr().out
    assert main(["compare", *folders, str(ONE), "--output", str(tmp_path / "out")]) == 2
    assert main(["compare", folders[0], "--output", str(tmp_path / "out")]) == 2
    assert "at least two folders" in capsys.readouterr().err


def test_a_load_that_differs_is_said() -> None:
    idle = [replace(result, load=0.1) for result in results(0.0)]
    busy = [replace(result, load=2.0) for result in results(0.0)]
    (comparison,) = compare({"a": idle, "b": busy})
    assert comparison.rows[-1].verdict == "not the same for both"


@pytest.mark.parametrize(
    ("samplers", "said"),
    [
        (["default"], "at least two --contender or --sampler"),
        (["default", "default"], "the same contender twice"),
        (["default", "sample-grasps=a:b"], "did you mean 'sample-grasp'"),
        (["default", "mine:domain=kichen"], "unknown domain 'kichen' .*; did you mean 'kitchen'"),
    ],
)
def test_what_cannot_be_compared_is_refused(
    tmp_path: Path, samplers: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    named = [part for one in samplers for part in ("--contender" if one.startswith("mine:") else "--sampler", one)]
    assert main(["compare", str(ONE), *named, "--output", str(tmp_path / "out"), "--no-execute"]) == 2
    assert re.search(said, capsys.readouterr().err)
