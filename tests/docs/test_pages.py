"""What the manual shows is run: its Python, its commands, and the tour from end to end."""

from __future__ import annotations

import importlib
import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from tamp.cli import main, parser
from tamp.contest.api.host import load
from tests.docs.manual import PAGES, ROOT, TUTORIALS, blocks, commands, files, named

BESIDE = [ROOT / name for name in ("CONTRIBUTING.md", "CHANGELOG.md", "scenarios/README.md")]
"""What else is written for readers."""


def test_pages_are_found() -> None:
    assert len(PAGES) > 10
    assert sum(len(commands(page)) for page in PAGES) > 10


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "python")], ids=named)
def test_python_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All blocks of a page in one go, in a folder from which the scenarios can be seen, with its files beside them."""
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    for title, text in files(page, "python").items():
        (tmp_path / title).write_text(text, encoding="utf-8")
        monkeypatch.delitem(sys.modules, Path(title).stem, raising=False)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    namespace: dict[str, object] = {"__name__": page.stem}
    lines = "import tamp\n" + "\n".join(text for _, text in blocks(page, "python"))
    exec(compile(lines, str(page), "exec", dont_inherit=True), namespace)


def test_grasps_from_the_cloud_are_planned_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The manual's block that takes pictures, which no others do."""
    pytest.importorskip("embreex", reason="the extra perception is not installed")
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    monkeypatch.chdir(tmp_path)
    ((name, text),) = files(ROOT / "docs" / "perception" / "index.md", "py").items()
    namespace: dict[str, object] = {"__name__": name}
    exec(compile(text, name, "exec", dont_inherit=True), namespace)
    assert namespace["plan"].actions  # type: ignore[attr-defined]


@pytest.mark.parametrize("page", [p for p in PAGES if commands(p)], ids=named)
def test_commands_are_understood(page: Path) -> None:
    for arguments in commands(page):
        words = [word.split(">")[0] for word in arguments if not word.startswith(("~", ">"))]
        options = parser().parse_args([word for word in words if word])
        assert options.run


def test_the_containers_of_the_manual_start_what_there_is() -> None:
    """Nothing here runs containers: the command is understood, and what is built has what the command needs."""
    text = (ROOT / "docs" / "guides" / "contest.md").read_text(encoding="utf-8")
    (compose,) = re.findall(r'```yaml title="compose.yaml"\n(.*?)```', text, re.DOTALL)
    database, contest = (yaml.safe_load(compose)["services"][name] for name in ("database", "contest"))
    options = parser().parse_args(contest["command"])
    port = contest["ports"][0].rpartition(":")[2]
    assert (str(options.data), str(options.port)) == (contest["volumes"][0].partition(":")[2], port)
    password, name = (database["environment"][key] for key in ("POSTGRES_PASSWORD", "POSTGRES_DB"))
    assert options.database == f"postgresql+psycopg://postgres:{password}@database/{name}"
    assert options.database in text.partition("podman-compose exec")[2]
    extras = (ROOT / "pyproject.toml").read_text(encoding="utf-8").partition("[project.optional-dependencies]")[2]
    assert all(f"\n{extra} = [" in extras for extra in contest["build"]["args"]["EXTRAS"].split(","))


def test_the_tour_is_walked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = ROOT / "docs" / "start" / "tour.md"
    monkeypatch.chdir(tmp_path)
    for name, text in files(page, "yaml").items():
        Path(name).write_text(text, encoding="utf-8")
    for arguments in commands(page):
        few_frames = ["--frame", "4"] if arguments[0] == "render" else []
        assert main([*arguments, *few_frames]) == 0, arguments
    made = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")}
    assert {"plan.json", "poses.json", "runs.csv", "runs/report.html", "runs/tidy-0/run.gif"} <= made


def test_the_samplers_of_the_manual_fit(tmp_path: Path) -> None:
    """The page's module as a file, checked by the page's own command, in a process that stands beside it."""
    page = ROOT / "docs" / "guides" / "samplers.md"
    ((name, text),) = files(page, "python").items()
    (tmp_path / name).write_text(text, encoding="utf-8")
    (check,) = [arguments for arguments in commands(page) if arguments[:2] == ["samplers", "check"]]
    done = subprocess.run(
        [sys.executable, "-m", "tamp.cli", *check, "--task", str(ROOT / "scenarios" / "one_object.yaml")],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_solutions_of_the_manual_are_solutions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are loaded as the sandbox does; other tests run solutions like them."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    for page, names in (("contest", ["solution.py"]), ("ocrtoc_solutions", ["agent.py", "server.py"])):
        found = files(ROOT / "docs" / "guides" / f"{page}.md", "python")
        assert list(found) == names
        for name, text in found.items():
            (tmp_path / f"manual_{name}").write_text(text, encoding="utf-8")
            assert callable(load(tmp_path, f"manual_{Path(name).stem}").run)


def test_generated_parts_are_up_to_date() -> None:
    spec = importlib.util.spec_from_file_location("hooks", ROOT / "docs" / "hooks.py")
    assert spec is not None and spec.loader is not None
    hooks = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(hooks)
    for page in hooks.pages():
        text = page.read_text(encoding="utf-8")
        assert text == hooks.refreshed(text), f"{page.name} is out of date: python docs/hooks.py writes it anew"


@pytest.mark.parametrize("page", [*PAGES, *TUTORIALS, *BESIDE], ids=named)
def test_links_lead_to_files(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)", page.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), f"{named(page)} links to {target}, which is not there"


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_every_module_that_a_page_names_is_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8").replace('entry-points."tamp.', "")  # groups of entry points are no modules
    for name in sorted(set(re.findall(r"\btamp(?:\.[A-Za-z_][A-Za-z_0-9]*)+", text))):
        if name.endswith((".yaml", ".css", ".md")):
            continue
        parts = name.split(".")
        for count in range(len(parts), 0, -1):
            try:
                found = importlib.import_module(".".join(parts[:count]))
            except ModuleNotFoundError:
                continue
            for attribute in parts[count:]:
                assert hasattr(found, attribute), f"{page.name} names {name}, which is not there"
                found = getattr(found, attribute)
            break
