"""A newcomer reads the README alone: its task, its commands, in an empty folder, until a report can be looked at."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.browser import CHROMIUM, look
from tests.docs.manual import README, commands, files


def test_from_the_readme_to_a_report(tmp_path: Path) -> None:
    for name, text in files(README, "yaml").items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    asked = commands(README)
    assert [words[0] for words in asked] == ["solve", "render", "report"]
    for words in asked:
        few_frames = ["--frame", "4"] if words[0] == "render" else []
        done = subprocess.run(
            [sys.executable, "-m", "tamp", *words, *few_frames], capture_output=True, text=True, cwd=tmp_path
        )
        assert done.returncode == 0, done.stdout + done.stderr
    page = tmp_path / "runs" / "report.html"
    told = page.read_text(encoding="utf-8")
    assert "tidy" in told and 'src="tidy-0/run.gif"' in told
    assert (tmp_path / "runs" / "tidy-0" / "run.gif").stat().st_size > 10_000
    if CHROMIUM is not None:
        assert look(page.as_uri(), tmp_path / "report.png") == []
