"""Hostile inputs: whatever a file holds, it is read or refused in one sentence, in time and in little memory.

Each input is read by a worker process; one that raises anything but a TampError, computes for over two seconds, uses
over one GiB, or ends its process is kept in a folder that the benchmark names. All of `tracebacks`, `hangs`, `memory`
and `deaths` must be 0. Plans that can be read are also checked. A concave mesh that is closed and does not cut through
itself is decomposed, once, in a process of its own that may compute for a minute: that is work, and no hang.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import resource
import shutil
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from random import Random
from typing import Any

from benchmarks.parts.fuzz_inputs import hostile_json, hostile_text
from benchmarks.parts.harness import Row, main
from tamp.checking import check
from tamp.errors import TampError
from tamp.language import parse_domain, parse_streams
from tamp.task import Mesh
from tamp.task.files.load import load_task
from tamp.task.files.plan_file import load_plan, save_plan
from tamp.task.mesh.decompose import LIMIT_S
from tamp.task.mesh.mesh_file import read_mesh
from tamp.task.mesh.parts import parts
from tests.checking.handmade import two_boxes

MEMORY = 2**30
SILENCE_S = 120.0
"""A worker that says nothing for so long hangs, whatever else the machine does [wall s]."""
DOMAIN = Path("domains/tabletop/domain.pddl")


@dataclass(frozen=True)
class Kind:
    """A kind of input: the file's name, valid texts, how they are spoilt, who reads the file, and how long he may."""

    file: str
    seeds: Sequence[str]
    spoil: Callable[[Sequence[str], Random], bytes]
    read: Callable[[Path], Any]
    share: float
    seconds: float = 2.0


def run(quick: bool) -> Sequence[Row]:
    total = 400 if quick else 20_000
    logging.getLogger("tamp").setLevel(logging.ERROR)  # no word of each mesh that is decomposed
    os.environ["XDG_CACHE_HOME"] = tempfile.mkdtemp(prefix="tamp-fuzz-cache-")  # decompositions of spoilt meshes
    kept = Path(tempfile.mkdtemp(prefix="tamp-fuzz-"))
    rows = [_row(kind, round(total * kind.share), kept) for kind in kinds()]
    shutil.rmtree(os.environ["XDG_CACHE_HOME"])
    counts = ("inputs", "read", "refused", "tracebacks", "hangs", "memory", "deaths")
    return [*rows, {"kind": "all", **{key: sum(row[key] for row in rows) for key in counts}}]


def kinds() -> Sequence[Kind]:
    """What is fuzzed."""
    tasks = [file.read_text(encoding="utf-8") for file in sorted(Path("scenarios").glob("*.yaml"))]
    meshes = [file.read_text(encoding="utf-8") for file in sorted(Path("scenarios/objects").glob("*/*.obj"))]
    domain, streams = (DOMAIN.with_name(name).read_text(encoding="utf-8") for name in ("domain.pddl", "stream.pddl"))
    task, plan = two_boxes()
    with tempfile.TemporaryDirectory() as folder:
        save_plan(plan, Path(folder) / "plan.json")
        text = (Path(folder) / "plan.json").read_text(encoding="utf-8")
    known = parse_domain(DOMAIN)
    return (
        Kind("task.yaml", tasks, hostile_text, _read_task, 0.3),
        Kind("domain.pddl", [domain], hostile_text, parse_domain, 0.2),
        Kind("stream.pddl", [streams, domain], hostile_text, lambda path: parse_streams(path, known), 0.2),
        Kind("mesh.obj", meshes, hostile_text, read_mesh, 0.15),
        Kind("decomposed.obj", meshes, hostile_text, lambda path: parts(Mesh(path, 1.0)), 0.01, LIMIT_S + 2.0),
        Kind("plan.json", [text], hostile_json, lambda path: check(task, load_plan(path)), 0.14),
    )


def _read_task(path: Path) -> None:
    for thing in load_task(path).objects:
        parts(thing.shape)


def _row(kind: Kind, count: int, kept: Path) -> Row:
    row: Row = {"kind": kind.file, "inputs": count, "read": 0, "refused": 0, "tracebacks": 0, "hangs": 0, "memory": 0}
    row |= {"deaths": 0, "slowest_s": 0.0, "peak_mib": 0}
    for index, said in _answers(kind, count):
        failure = _failure(said, kind.seconds)
        row[failure or said["ended"]] += 1
        row["slowest_s"] = max(row["slowest_s"], said.get("seconds", 0.0))
        row["peak_mib"] = max(row["peak_mib"], said.get("peak", 0) >> 20)
        if failure is not None:
            file = kept / f"{index}-{kind.file}"
            file.write_bytes(kind.spoil(kind.seeds, Random(index)))
            print(f"{failure}: {file}: {said.get('seconds', 0.0):.1f} s\n{said.get('text', '')}", flush=True)
    return row


def _failure(said: Mapping[str, Any], seconds: float) -> str | None:
    if said["ended"] in ("tracebacks", "hangs", "deaths"):
        return str(said["ended"])
    if said["seconds"] > seconds:
        return "hangs"
    return "memory" if said["peak"] > MEMORY else None


def _answers(kind: Kind, count: int) -> Iterator[tuple[int, dict[str, Any]]]:
    """What came of each input. A worker that hangs, dies or has grown fat is replaced by another."""
    context, index = multiprocessing.get_context("fork"), 0
    while index < count:
        ours, theirs = context.Pipe(duplex=False)
        worker = context.Process(target=_work, args=(theirs, kind, range(index, count)))
        worker.start()
        theirs.close()
        said: dict[str, Any] = {"ended": "read", "peak": 0}
        while index < count and said["ended"] not in ("hangs", "deaths") and said["peak"] <= MEMORY:
            said = _next_word(ours)
            yield index, said
            index += 1
        worker.kill()
        worker.join()


def _next_word(connection: Connection) -> dict[str, Any]:
    if not connection.poll(SILENCE_S):
        return {"ended": "hangs"}
    try:
        said: dict[str, Any] = connection.recv()
    except EOFError:
        return {"ended": "deaths"}
    return said


def _work(connection: Connection, kind: Kind, indices: range) -> None:
    """In the worker: spoil and read one input after the other, and say what came of each."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree("scenarios/objects", Path(folder) / "objects")
        path = Path(folder) / kind.file
        for index in indices:
            path.write_bytes(kind.spoil(kind.seeds, Random(index)))
            start, text = _computed(), ""
            try:
                kind.read(path)
                ended = "read"
            except TampError:
                ended = "refused"
            except Exception:
                ended, text = "tracebacks", traceback.format_exc()
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
            connection.send({"ended": ended, "seconds": _computed() - start, "peak": peak, "text": text})


def _computed() -> float:
    """Processor time of this process and of those that it has waited for [s]."""
    return time.process_time() + sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])


if __name__ == "__main__":
    main("fuzz", run)
