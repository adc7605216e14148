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

Parts = tuple[tuple[str, str], ...]


def named_parts(configuration: Mapping[str, Any], task: Task) -> Parts:
    """What options and task name that may be code of one's own: option, and an address or an installed name; sorted.

    Args:
        configuration: the options of a run, JSON-like, as `tamp.pipeline.options.settings.Settings` has them.
        task: whose own samplers, domain and parts count where the options name no other.
    """
    samplers = {**task.samplers, **(configuration.get("samplers") or {})}
    single = {field: configuration.get(field) or getattr(task, field, None) for field in ("domain", *KINDS, "perceive")}
    named = {("samplers", said) for said in samplers.values()} | {
        (field, said) for field, said in single.items() if said
    }
    return tuple(sorted(named))


def code_files(parts: Parts) -> tuple[Path, ...]:
    """The files of parts that are no built-in ones, sorted; what is not there has none."""
    make_importable("domains")
    make_importable("samplers")
    modules = {_address(option, name).partition(":")[0] for option, name in parts}
    own = sorted(name for name in modules if name.partition(".")[0] not in ("", __name__.partition(".")[0]))
    return tuple(sorted({file for module in own for file in _files(module)}))


def code_sha256(parts: Parts) -> str:
    """SHA-256 over the names and contents of `code_files`; empty where there are none."""
    files = code_files(parts)
    whole = hashlib.sha256()
    for file in files:
        whole.update(f"{file.name}\0".encode() + hashlib.sha256(file.read_bytes()).digest())
    return whole.hexdigest() if files else ""


def _address(option: str, name: str) -> str:
    """The address "package.module:NAME", or "package.module", of a part; empty where it is a built-in one."""
    from tamp.domains.catalog import module_of

    if option == "domain":
        return module_of(name)
    if ":" in name or option == "perceive":
        return name if ":" in name else ""
    return addresses("samplers" if option == "samplers" else KINDS[option]).get(name, "")


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
