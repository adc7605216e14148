"""The files of the code of one's own that decide a run: found without importing any of it.

A module's helpers lie beside it: of one in a package, all of that package's Python and PDDL files count; of one outside
any package its file alone does. Code of this program is told apart by the versions that results record.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tamp.plugins import Kind, addresses, make_importable
from tamp.task import Task

if TYPE_CHECKING:
    from importlib.machinery import ModuleSpec

KINDS: Mapping[str, Kind] = {
    "strategy": "strategies", "search": "searches", "simulator": "simulators", "settling": "simulators",
}  # fmt: skip
"""Options that name a part -> the entry points that give such parts names."""


def code_files(configuration: Mapping[str, Any], task: Task) -> tuple[Path, ...]:
    """The files of what options and task name by an address or an installed name, sorted; what is not there has none.

    Args:
        configuration: the options of a run, JSON-like, as `tamp.pipeline.options.settings.Settings` has them.
        task: whose own samplers, domain and parts count where the options name no other.
    """
    make_importable("domains")
    make_importable("samplers")
    modules = {name.partition(":")[0] for name in _named(configuration, task)}
    own = sorted(name for name in modules if name.partition(".")[0] != __name__.partition(".")[0])
    return tuple(sorted({file for module in own for file in _files(module)}))


def code_sha256(configuration: Mapping[str, Any], task: Task) -> str:
    """SHA-256 over the names and contents of `code_files`; empty where there are none."""
    files = code_files(configuration, task)
    whole = hashlib.sha256()
    for file in files:
        whole.update(f"{file.name}\0".encode() + hashlib.sha256(file.read_bytes()).digest())
    return whole.hexdigest() if files else ""


def _named(configuration: Mapping[str, Any], task: Task) -> Iterator[str]:
    """Addresses "package.module:NAME", or "package.module", of the parts that are no built-in ones."""
    from tamp.domains.catalog import module_of

    samplers = {**task.samplers, **(configuration.get("samplers") or {})}
    yield from _addressed("samplers", samplers.values())
    yield module_of(configuration.get("domain") or task.domain)
    for field, kind in KINDS.items():
        yield from _addressed(kind, [configuration.get(field) or getattr(task, field, None) or ""])
    yield from (said for said in [configuration.get("perceive") or ""] if ":" in said)


def _addressed(kind: Kind, names: Any) -> Iterator[str]:
    known = addresses(kind)
    yield from (name if ":" in name else known[name] for name in names if ":" in name or name in known)


def _files(module: str) -> Iterator[Path]:
    """The files of a module, and of the package that it is or lies in."""
    folders: list[str] | None = None
    parts = module.split(".")
    for number in range(len(parts)):
        spec = _spec(".".join(parts[: number + 1]), folders)
        if spec is None:
            return
        if spec.has_location and spec.origin and spec.submodule_search_locations is None and folders is None:
            yield Path(spec.origin)
        folders = folders if spec.submodule_search_locations is None else list(spec.submodule_search_locations)
    for folder in folders or ():
        yield from (file for kind in ("*.py", "*.pddl") for file in Path(folder).rglob(kind))


def _spec(name: str, folders: list[str] | None) -> ModuleSpec | None:
    """Where a module is, by whatever finds modules here; nothing is imported."""
    specs = (finder.find_spec(name, folders) for finder in sys.meta_path)
    return next((spec for spec in specs if spec is not None), None)
