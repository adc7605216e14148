"""Standard output carries what was asked for, and nothing that samplers or native libraries print."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tamp.cli.output import asked_only

LOUD = """
import os, sys
from tamp.cli.output import asked_only
with asked_only() as out:
    print("a sampler's")
    os.write(1, b"a native library's\\n")
    os.system("echo another process")
    print("asked for", file=out)
print("after")
"""


def test_only_what_was_asked_for_reaches_standard_output() -> None:
    done = subprocess.run([sys.executable, "-c", LOUD], capture_output=True, text=True, check=True)
    assert done.stdout == "asked for\nafter\n"
    assert set(done.stderr.splitlines()) == {"a sampler's", "a native library's", "another process"}


def test_where_no_descriptor_is_read_what_python_prints_is_kept_apart(capsys: pytest.CaptureFixture[str]) -> None:
    with asked_only() as out:
        print("a sampler's")
        print("asked for", file=out)
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("asked for\n", "a sampler's\n")
