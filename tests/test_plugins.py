"""What users bring is found by name: packages' entry points, and folders that TAMP_DOMAINS and TAMP_SAMPLERS name."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tamp import plugins
from tamp.domains.catalog import domain_names, load_domain
from tamp.domains.samplers import load_sampler
from tamp.errors import DomainError, SamplerError, TampError
from tamp.execution.simulators import load_simulator
from tamp.pipeline.options.own import load_search

DOMAIN = "from tamp.domains.tabletop import DOMAIN as T\nDOMAIN = T.extended(name='{name}')\n"
SIMULATOR = "from tamp.execution.pybullet.simulator import PyBulletSimulator\nclass Windfall(PyBulletSimulator): pass\n"
ENTRIES = """\
[tamp.domains]
orchard = fruits.trees:ORCHARD

[tamp.samplers]
by-stem = fruits.hands:by_stem

[tamp.simulators]
windfall = fruits.physics:Windfall

[tamp.searches]
by-ear = fruits.hands:by_ear
"""


def write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


@pytest.fixture
def brought(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folders that the environment names, and a package installed beside it, as pip leaves them."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "fruits"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path / "site")])
    monkeypatch.setenv("TAMP_DOMAINS", str(tmp_path / "mine" / "domains"))
    monkeypatch.setenv("TAMP_SAMPLERS", str(tmp_path / "mine" / "samplers"))
    write(tmp_path / "mine" / "domains" / "plug_garden" / "__init__.py", DOMAIN.format(name="plug_garden"))
    write(tmp_path / "mine" / "samplers" / "plug_hands.py", "def by_hand(context, obj):\n    yield None\n")
    site = tmp_path / "site"
    write(site / "fruits" / "__init__.py", "")
    write(site / "fruits" / "trees.py", DOMAIN.format(name="orchard").replace("DOMAIN =", "ORCHARD ="))
    write(site / "fruits" / "hands.py", "def by_stem(context, obj):\n    yield None\ndef by_ear(*task): pass\n")
    write(site / "fruits" / "physics.py", SIMULATOR)
    write(site / "fruits-1.0.dist-info" / "METADATA", "Metadata-Version: 2.1\nName: fruits\nVersion: 1.0\n")
    write(site / "fruits-1.0.dist-info" / "entry_points.txt", ENTRIES)
    return tmp_path


def test_domains_are_loaded_by_name(brought: Path) -> None:
    assert {"plug_garden", "orchard", "tabletop", "kitchen"} <= set(domain_names())
    assert load_domain("plug_garden").name == "plug_garden"
    assert load_domain("orchard").name == "orchard"
    with pytest.raises(DomainError, match="did you mean 'orchard'"):
        load_domain("orchid")


def test_samplers_are_named_by_entry_points_and_found_in_folders(brought: Path) -> None:
    assert load_sampler("by-stem", "sample-grasp").__name__ == "by_stem"
    assert load_sampler("plug_hands:by_hand", "sample-grasp").__name__ == "by_hand"
    with pytest.raises(SamplerError, match="nor an installed sampler: by-stem"):
        load_sampler("by-steam", "sample-grasp")


def test_simulators_are_named_by_entry_points(brought: Path) -> None:
    assert load_simulator("windfall").__name__ == "Windfall"
    with pytest.raises(TampError, match=r"unknown simulator 'storm'; valid are pybullet, .*windfall, and"):
        load_simulator("storm")


def test_searches_are_named_by_entry_points(brought: Path) -> None:
    assert load_search("by-ear", ("ff",)).__name__ == "by_ear"  # type: ignore[attr-defined]
    with pytest.raises(TampError, match=r"unknown search 'by-eye'; did you mean 'by-ear'\?"):
        load_search("by-eye", ("ff",))
    with pytest.raises(TampError, match=r"entry points tamp\.searches: 'by-ear' is the name of one that comes along"):
        load_search("by-air", ("by-ear",))


def test_a_folder_that_is_not_there_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TAMP_SAMPLERS", str(tmp_path / "nowhere"))
    with pytest.raises(TampError, match=r"TAMP_SAMPLERS names .*nowhere, which is no folder"):
        plugins.folders("samplers")


def test_a_built_in_name_is_not_taken_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "kitchen" / "__init__.py", "")
    monkeypatch.setenv("TAMP_DOMAINS", str(tmp_path))
    with pytest.raises(DomainError, match="'kitchen' is there twice"):
        domain_names()
