"""Whatever a sampler does, planning ends with its limit, and one sentence says who did what where."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import tamp
from tamp.errors import SamplerError

ONE = Path(__file__).parents[2] / "scenarios" / "one_object.yaml"
HERE = "tests.pipeline.bad_samplers"


def tamp_(*arguments: str) -> subprocess.CompletedProcess[str]:
    """The command in a process of its own, whose main thread it has."""
    return subprocess.run(
        [sys.executable, "-m", "tamp", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        cwd=Path(__file__).parents[2],
    )


@pytest.mark.parametrize("name", ["sleeps", "spins", "starts_a_thread"])
def test_planning_ends_with_its_limit_and_names_who_does_not(name: str) -> None:
    done = tamp_("plan", str(ONE), "--timeout", "3", "--sampler", f"sample-grasp={HERE}:{name}")
    assert done.returncode == 1, done.stderr
    assert "no plan (timeout)" in done.stderr
    assert f"the sampler of stream 'sample-grasp' went on past the limit for (red): {HERE}:{name}" in done.stderr
    assert "bad_samplers.py:" in done.stderr


@pytest.mark.parametrize("name", ["swallows", "spins_in_c"])
def test_a_command_ends_even_where_nothing_can_be_interrupted(tmp_path: Path, name: str) -> None:
    bad = ["--timeout", "2", "--sampler", f"sample-grasp={HERE}:{name}"]
    done = tamp_("plan", str(ONE), *bad, "--json", "-")
    assert (done.returncode, json.loads(done.stdout)["status"]) == (1, "timeout")
    done = tamp_("solve", str(ONE), *bad, "--output", str(tmp_path / "out"), "--json", "-")
    (result,) = json.loads(done.stdout)
    assert (done.returncode, result["status"]) == (1, "timeout")
    assert "planning did not end with its limit" in result["message"]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("raises", "the sampler of stream 'sample-grasp' raised ValueError: no idea how to grasp red for (red)"),
        ("refuses", "the sampler of stream 'sample-grasp' raised TaskError: not this one for (red)"),
        ("interrupts", "the sampler of stream 'sample-grasp' raised KeyboardInterrupt for (red)"),
        ("exits", "the sampler of stream 'sample-grasp' tried to end the program for (red)"),
        ("yields_words", "stream 'sample-grasp': expected to yield a Grasp, found 'from above'"),
        ("yields_a_matrix", "stream 'sample-grasp': expected to yield a Grasp, found array([[1.,"),
        ("returns_a_number", "expected a generator function that yields one output at a time"),
    ],
)
def test_what_a_sampler_does_wrong_is_one_sentence_with_its_line(name: str, said: str) -> None:
    with pytest.raises(SamplerError) as caught:
        tamp.plan(tamp.load_task(ONE), samplers={"sample-grasp": f"{HERE}:{name}"}, timeout=20.0)
    assert said in str(caught.value)
    assert f"{HERE}:{name} at tests/pipeline/bad_samplers.py:" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_wrong_sampler_in_a_batch_is_an_error_without_a_traceback(tmp_path: Path) -> None:
    done = tamp_("solve", str(ONE), "--sampler", f"sample-grasp={HERE}:raises", "--output", str(tmp_path / "out"))
    assert done.returncode == 1
    assert "error" in done.stdout
    assert "raised ValueError: no idea how to grasp red" in done.stdout
    assert "Traceback" not in done.stdout + done.stderr


def test_nothing_for_ever_is_a_timeout_and_prints_are_not_results(tmp_path: Path) -> None:
    no_regrasp = ["--sampler", "sample-regrasp=tamp.streams.nothing:nothing"]  # the other way to the goal
    unending = ["--timeout", "2", "--sampler", f"sample-grasp={HERE}:yields_nothing"]
    nothing = tamp_("plan", str(ONE), *unending, *no_regrasp)
    assert "no plan (timeout)" in nothing.stderr
    for command in (["plan", str(ONE)], ["solve", str(ONE), "--output", str(tmp_path / "out")]):
        printed = tamp_(*command, "--timeout", "2", "--sampler", f"sample-grasp={HERE}:prints", "--json", "-")
        assert json.loads(printed.stdout), "nothing but what was asked for"
        assert {"a sampler's print", "a native print"} <= set(printed.stderr.splitlines())


def test_a_sampler_that_ends_the_process_from_below_is_no_success(tmp_path: Path) -> None:
    bad = ["--sampler", f"sample-grasp={HERE}:ends", "--json", "-"]
    for command in (["plan"], ["-v", "plan"]):
        done = tamp_(*command, str(ONE), *bad)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.endswith("tamp: a sampler ended the program\n")
    (result,) = json.loads(tamp_("solve", str(ONE), *bad, "--output", str(tmp_path / "out")).stdout)
    assert result["status"] == "error"


@pytest.mark.parametrize(
    ("command", "named"),
    [
        (["plan", str(ONE), "--search"], "a search"),
        (["plan", str(ONE), "--samp"], "a sampler"),
        (["solve", str(ONE), "--sampler"], "a sampler"),
        (["perceive", str(ONE), "--perceiver"], "a perceiver"),
    ],
)
def test_what_ends_the_process_as_it_is_imported_is_no_success(command: list[str], named: str, tmp_path: Path) -> None:
    stream = "sample-grasp=" * (named == "a sampler")
    output = ["--output", str(tmp_path / "out")] * (command[0] == "solve")
    done = tamp_(*command, f"{stream}tests.pipeline.ends_as_imported:it", *output)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"tamp: {named} ended the program\n")


@pytest.mark.parametrize("name", ["forks", "closes_streams"])
def test_what_a_sampler_does_to_the_process_does_not_spoil_what_is_printed(name: str) -> None:
    done = tamp_("plan", str(ONE), "--sampler", f"sample-grasp={HERE}:{name}", "--json", "-")
    assert (done.returncode, json.loads(done.stdout)["status"]) == (0, "planned"), done.stderr
    assert "Traceback" not in done.stderr
