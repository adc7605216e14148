"""The record of a result and its line of JSON."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.errors import TampError
from tamp.results import Result, from_json, print_table, read_results, summary, table_lines, to_json

CONTRACT = {
    "task", "seed", "status", "planning_s", "execution_sim_s", "wall_s", "n_actions", "n_replans", "grasps_attempted",
    "grasps_succeeded", "plan_checked", "ede_m", "do_nothing_ede_m", "mean_ueb_m", "improvement", "improvement_ueb",
    "objects", "plan_sha256", "message", "versions",
}  # fmt: skip

results = st.builds(
    Result,
    task=st.text(max_size=5),
    seed=st.integers(0, 9),
    status=st.sampled_from(["solved", "failed", "timeout", "infeasible", "invalid", "error"]),
    ede_m=st.none() | st.floats(0, 1),
    do_nothing_ede_m=st.none() | st.floats(0, 1),
    objects=st.just(({"name": "a", "ede_m": 0.1, "ueb_m": 0.5, "error_m": 0.1, "lost": False},)),
    goals_met=st.dictionaries(st.text(max_size=3), st.booleans(), max_size=2),
    message=st.text(),
)


@given(results)
def test_a_result_survives_its_line(result: Result) -> None:
    line = to_json(result)
    assert "\n" not in line
    assert from_json(line) == result
    assert set(json.loads(line)) >= CONTRACT


def test_an_unknown_status_is_refused() -> None:
    with pytest.raises(ValueError, match="valid are solved"):
        Result("t", 0, "fine")  # type: ignore[arg-type]


@pytest.mark.parametrize("line", ["", "3", "{}", "[]", '{"task": "t", "seed": 0, "status": "x"}', "[" * 100_000])
def test_a_line_that_is_no_result_is_refused(line: str) -> None:
    with pytest.raises(TampError, match="not a result"):
        from_json(line)


def test_what_a_line_lacks_is_named() -> None:
    with pytest.raises(TampError, match=r"^line 3: not a result: it lacks seed and status$"):
        from_json('{"task": "t"}', "line 3")


def test_a_torn_last_line_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    path.write_text(to_json(Result("a", 0, "solved")) + "\n" + to_json(Result("b", 0, "solved"))[:20], encoding="utf-8")
    assert [r.task for r in read_results(path)] == ["a"]
    assert read_results(tmp_path / "none") == ()


def test_the_table_has_a_row_a_result_and_no_colour_off_a_terminal() -> None:
    rows = [
        Result("swap", 0, "solved", ede_m=0.01, do_nothing_ede_m=0.4, improvement=0.975),
        Result("long" * 20, 1, "failed", message="[red] is no markup"),
    ]
    file = io.StringIO()
    print_table(rows, file)
    lines = file.getvalue().splitlines()
    assert "\x1b" not in file.getvalue()
    assert lines[1].split()[:3] == ["swap", "0", "solved"]
    assert "[red] is no markup" in lines[3]
    assert lines[-1] == summary(rows) == "1 of 2 solved; mean EDE 1.00 cm, doing nothing 40.00 cm"


@given(st.lists(results, max_size=5), st.integers(1, 200))
def test_a_narrow_terminal_costs_columns_but_no_letter_of_a_name(given: list[Result], width: int) -> None:
    whole, narrow = table_lines(given), table_lines(given, width)
    for result, line in zip(given, narrow[1:], strict=True):
        assert line.startswith(result.task.rstrip())
        assert result.status in line
    assert max(map(len, whole)) <= width or len(narrow[0]) < len(whole[0])


def test_eighty_columns_hold_a_table_of_long_names() -> None:
    lines = table_lines([Result("a_task_whose_name_is_rather_long_for_a_table", 0, "solved", ede_m=0.01)], 80)
    assert max(map(len, lines)) <= 80
    assert lines[1].startswith("a_task_whose_name_is_rather_long_for_a_table")
    assert "EDE cm" in lines[0]


def test_what_a_file_says_does_not_work_the_terminal() -> None:
    out = io.StringIO()
    print_table([Result("a\x1b[2J", 0, "failed", message="b\x1b]0;title\x07\nc")], out)
    assert all(sign.isprintable() or sign == "\n" for sign in out.getvalue())
    assert out.getvalue().count("\n") == 4
