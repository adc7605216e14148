"""Headless Chromium, Debian's package, for tests that look at pages; they are skipped where it is not installed."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

CHROMIUM = shutil.which("chromium")

needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no chromium; `apt-get install chromium` brings it")


def look(url: str, picture: Path, *, seconds: float = 3.0, size: tuple[int, int] = (1200, 1600)) -> list[str]:
    """Open a page, write a screenshot, and return what its console says.

    Args:
        url: http: or file:.
        picture: the PNG.
        seconds: of the page's own time before the picture is taken.
        size: of the window [pixels].
    """
    assert CHROMIUM is not None
    options = ["--headless", "--no-sandbox", "--hide-scrollbars", "--use-gl=angle", "--use-angle=swiftshader"]
    options += ["--enable-unsafe-swiftshader", "--enable-logging=stderr", "--disable-dev-shm-usage"]
    options += [f"--user-data-dir={picture.parent / 'profile'}", f"--virtual-time-budget={int(1000 * seconds)}"]
    options += [f"--screenshot={picture}", f"--window-size={size[0]},{size[1]}", url]
    done = subprocess.run([CHROMIUM, *options], capture_output=True, text=True, timeout=120, check=True)
    return re.findall(r"CONSOLE[^\"]*\"(.*)\"", done.stderr)
