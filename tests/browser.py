"""Headless Chromium, Debian's package, for tests that look at pages; they are skipped where it is not installed."""

from __future__ import annotations

import base64
import io
import json
import re
import shutil
import subprocess
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

CHROMIUM = shutil.which("chromium")

needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no chromium; `apt-get install chromium` brings it")

ALWAYS = ("--headless", "--no-sandbox", "--hide-scrollbars", "--disable-dev-shm-usage")


def look(url: str, picture: Path, *, seconds: float = 3.0, size: tuple[int, int] = (1200, 1600)) -> list[str]:
    """Open a page, write a screenshot, and return what its console says.

    Args:
        url: http: or file:.
        picture: the PNG.
        seconds: of the page's own time before the picture is taken.
        size: of the window [pixels].
    """
    assert CHROMIUM is not None
    options = ["--disable-gpu", "--enable-logging=stderr", f"--virtual-time-budget={int(1000 * seconds)}"]
    options += [f"--user-data-dir={picture.parent / 'profile'}", f"--window-size={size[0]},{size[1]}"]
    command = [CHROMIUM, *ALWAYS, *options, f"--screenshot={picture}", url]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    return re.findall(r"CONSOLE[^\"]*\"(.*)\"", done.stderr)


def watch(url: str, folder: Path, seen: Callable[[Image.Image], bool], *, limit: float = 240.0) -> bool:
    """Open a page that draws in three dimensions, and look again and again until `seen` says yes; False at the limit.

    Args:
        url: http: or file:.
        folder: for the browser's own files.
        seen: what is waited for.
        limit: real time [s].
    """
    from websockets.sync.client import connect

    assert CHROMIUM is not None
    options = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--remote-debugging-port=0"]
    options += [f"--user-data-dir={folder / 'profile'}", "--window-size=640,480"]
    end = time.monotonic() + limit
    browser = subprocess.Popen([CHROMIUM, *ALWAYS, *options, url], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        with connect(_debugger(folder / "profile" / "DevToolsActivePort", end), max_size=None) as socket:
            while time.monotonic() < end:
                socket.send(json.dumps({"id": 1, "method": "Page.captureScreenshot"}))
                answer = json.loads(socket.recv(timeout=limit))
                if seen(Image.open(io.BytesIO(base64.b64decode(answer["result"]["data"])))):
                    return True
        return False
    finally:
        browser.kill()
        browser.wait()


def _debugger(file: Path, end: float) -> str:
    """Address of the page's debugger, once the browser has written its port down and has the page open."""
    while time.monotonic() < end:
        if file.is_file() and (text := file.read_text(encoding="utf-8")):
            with urllib.request.urlopen(f"http://localhost:{text.split()[0]}/json", timeout=60) as answer:
                for target in json.load(answer):
                    if target["type"] == "page":
                        return str(target["webSocketDebuggerUrl"])
        time.sleep(0.1)
    raise TimeoutError("the browser did not start")
