"""The manual as a site: it builds without warnings, every link of its pages leads somewhere, every picture is told."""

from __future__ import annotations

import shutil
import subprocess
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from tests.docs.manual import ROOT

pytestmark = pytest.mark.skipif(shutil.which("mkdocs") is None, reason="the extra 'docs' is missing")


class Page(HTMLParser):
    """What a page of the site refers to, and what may refer to in it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.untold: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors.update(given[name] for name in ("id", "name") if name in given)
        self.links.extend(given[name] for name in ("href", "src") if name in given)
        if tag == "img" and not given.get("alt"):
            self.untold.append(given.get("src", "")[:100])


@cache
def read(page: Path) -> Page:
    return Page(page.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("manual") / "site"
    command = ["mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    return folder


def pages(site: Path) -> list[Path]:
    """Every page but that for what is missing, whose links begin at the site's address."""
    found = sorted(page for page in site.rglob("*.html") if page.name != "404.html")
    assert len(found) > 15
    return found


def test_formulas_are_parts_of_their_sentences(site: Path) -> None:
    score = (site / "reference" / "score.html").read_text(encoding="utf-8")
    assert "<math" in score
    assert "<p><math" not in score and "</math>\n" not in score.replace("</math></span>", "")  # sentences go on


def test_links_lead_to_pages_and_to_places_in_them(site: Path) -> None:
    astray = []
    for page in pages(site):
        for link in read(page).links:
            address = urlsplit(link)
            if address.scheme or address.fragment.startswith("__"):  # another site's; the theme's switches
                continue
            target = (page.parent / unquote(address.path)).resolve() if address.path else page
            if not target.exists() or (address.fragment and unquote(address.fragment) not in read(target).anchors):
                astray.append((page.name, link))
    assert not astray


def test_pictures_say_what_they_show(site: Path) -> None:
    untold = {page.name: read(page).untold for page in pages(site) if read(page).untold}
    assert not untold
