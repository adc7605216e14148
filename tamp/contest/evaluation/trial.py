"""One run of a solution on a task in a simulator: isolated, timed, and scored by the truth."""

from __future__ import annotations

import json
import socket
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from tamp.clock import TimeUp, ended_at, now
from tamp.contest.api.wire import FROM_SOLUTION, Channel
from tamp.contest.evaluation.session import serve, serve_loading
from tamp.contest.evaluation.workcell import Workcell
from tamp.contest.package import Package
from tamp.contest.rules import Rules
from tamp.contest.sandbox.isolation import Ending, Sandbox, visible
from tamp.contest.sandbox.process import SandboxedProcess
from tamp.contest.sandbox.runtime import MODELS, SOLUTION, make_room, start
from tamp.contest.sandbox.seccomp import call_filter
from tamp.errors import PartError, TampError
from tamp.execution.log import Frame
from tamp.execution.simulators import make_simulator
from tamp.formats.obj import shape_obj
from tamp.perception.cameras.setup import OCRTOC_2021, load_setup
from tamp.perception.rendering.scene import surfaces
from tamp.perception.rendering.surface import Surface, write_ply
from tamp.results import Result
from tamp.scoring import score
from tamp.task import At, In, On, Pose, Task, load_robot
from tamp.versions import versions

FILM_S = 0.4
"""Simulated time between two frames of a film [s]."""

BEYOND_S = 30.0
"""What a scene may take past a solution's limit, at which that is ended, before its simulator counts as hanging [s]."""


class NotBegunError(TampError):
    """The sandbox ended before anything of the solution was run: no fault of the solution's."""


@dataclass(frozen=True)
class Trial:
    """What came of a run.

    Attributes:
        result: the record; its `settings` say how the run ended.
        ending: how it ended.
        log: what the solution printed.
        frames: the film of it.
    """

    result: Result
    ending: Ending
    log: bytes
    frames: tuple[Frame, ...]


def run_trial(
    task: Task, package: Package, *, rules: Rules, simulator: str, run: int, sandbox: Sandbox, film: bool = False
) -> Trial:
    """Run a solution once; whatever it does, there is a result.

    Args:
        task: what is to be done, and the truth.
        package: the solution.
        rules: of the contest.
        simulator: by name.
        run: number of the run, from 0; decides the seed.
        sandbox: where the solution runs.
        film: record frames.

    Raises:
        TampError: where task, simulator, cameras or an offered library cannot be used; NotBegunError where the sandbox
            did not begin.
        PartError: where a simulator of one's own raises, answers wrongly, or does not come back.
    """
    began, seed = time.monotonic(), rules.seed + run
    robot = load_robot(task.robot)
    cameras = load_setup(_setup(rules), robot)
    looks = surfaces(task)
    with tempfile.TemporaryDirectory(prefix="tamp-contest-") as folder:
        objects = write_models(task, looks, Path(folder))
        try:
            with (
                ended_at(now() + rules.limits.wall_s + BEYOND_S),
                make_simulator(simulator, task.objects, table=task.table, robot=robot) as world,
            ):
                workcell = Workcell(
                    task, world, cameras, looks, seed=seed, limit_s=rules.execution_s, renderer=rules.renderer,
                    film_s=FILM_S if film else None,
                )  # fmt: skip
                ending, log = run_solution(workcell, package, Path(folder), objects, rules, sandbox)
                used, poses = workcell.time, workcell.final_poses()
        except TimeUp:  # the solution itself is ended before
            limit = f"{rules.limits.wall_s:g} s that a run may take"
            raise PartError(f"simulator {simulator!r} did not come back within the {limit}") from None
    if ending.reason == "start":
        printed = log.decode("utf-8", errors="replace").strip().splitlines()
        raise NotBegunError(f"the sandbox did not begin: {visible(': '.join([ending.message, *printed[-1:]]))}")
    result = _result(task, poses, workcell, ending, simulator, run, used, time.monotonic() - began)
    return Trial(result, ending, log, tuple(workcell.frames))


def run_solution(
    workcell: Workcell,
    package: Package,
    models: Path,
    objects: Sequence[Mapping[str, Any]],
    rules: Rules,
    sandbox: Sandbox,
) -> tuple[Ending, bytes]:
    """Start a solution in a sandbox, answer its calls until it ends, and leave nothing of it behind.

    Args:
        workcell: the scene.
        package: the solution.
        models: folder of the objects' meshes.
        objects: what is asked of each.
        rules: its limits and the libraries it may import.
        sandbox: where it runs.

    Returns:
        How it ended, and what it printed.
    """
    ours, theirs = socket.socketpair()
    with ours, _started(package, models, rules, sandbox, theirs, run=True) as process:
        theirs.close()
        ending = serve(Channel(ours, FROM_SOLUTION), workcell, process, objects, rules.limits.answers_s)
    return process.stopped or ending, process.output


def cannot_load(package: Package, rules: Rules, sandbox: Sandbox) -> tuple[str, bytes]:
    """Why a solution cannot be made, in a line, and what it printed; empty where it can, or the sandbox did not begin.

    It is made in a sandbox where there is nothing of any task, nor anybody who answers, and not run.
    """
    ours, theirs = socket.socketpair()
    with (
        ours,
        tempfile.TemporaryDirectory(prefix="tamp-contest-") as folder,
        _started(package, Path(folder), rules, sandbox, theirs, run=False) as process,
    ):
        theirs.close()
        ending = serve_loading(Channel(ours, FROM_SOLUTION), process)
    ending = process.stopped or ending
    return ("", b"") if ending.reason in ("finished", "start") else (ending.message, process.output)


def _started(
    package: Package, models: Path, rules: Rules, sandbox: Sandbox, speaks: socket.socket, *, run: bool
) -> SandboxedProcess:
    """A solution's process with its socket; it may be only to make the solution, and not to run it."""
    room = make_room(package.folder.resolve(), models.resolve(), rules.libraries, rules.limits.scratch_mb)
    arguments = {
        "descriptor": speaks.fileno(),
        "run": run,
        "solution": sandbox.inside(room, SOLUTION),
        "models": sandbox.inside(room, MODELS),
        "module": package.module,
        "libraries": rules.libraries,
        "limits": rules.limits.rlimits(isolated=sandbox.isolates),
        "filter": call_filter() if sandbox.isolates else [],
    }
    return SandboxedProcess(sandbox, room, start(sandbox, json.dumps(arguments)), rules.limits, speaks.fileno())


def _setup(rules: Rules) -> Path:
    if rules.cameras is None:
        return OCRTOC_2021
    return (Path() if rules.path is None else rules.path.parent) / rules.cameras


def _result(
    task: Task, poses: dict[str, Pose], workcell: Workcell, ending: Ending, simulator: str, run: int, used: float,
    wall_s: float,
) -> Result:  # fmt: skip
    found = score(task, poses)
    return Result(
        task=task.name,
        seed=run,
        status="solved" if found.solved else "failed",
        execution_sim_s=used,
        wall_s=wall_s,
        grasps_attempted=workcell.grasps.attempted,
        grasps_succeeded=workcell.grasps.succeeded,
        ede_m=found.ede_m,
        do_nothing_ede_m=found.do_nothing_ede_m,
        mean_ueb_m=found.mean_ueb_m,
        improvement=found.improvement,
        improvement_ueb=found.improvement_ueb,
        objects=tuple(vars(item) for item in found.objects),
        goals_met=found.goals_met,
        message="" if ending.reason == "finished" else f"{ending.reason}: {ending.message}",
        versions=_versions(),
        level=task.level,
        simulator=simulator,
        settings={"ended": ending.reason},
    )


@cache
def _versions() -> dict[str, str]:
    return dict(versions())


def write_models(task: Task, looks: dict[str, Surface], folder: Path) -> list[dict[str, Any]]:
    """Write the models that a task needs, and say what is asked of each object; start poses are left out.

    Returns:
        An entry an object, as `tamp.contest.api.schema.OBJECT` describes it.

    Raises:
        TaskError: where a mesh cannot be read.
    """
    entries = []
    for index, obj in enumerate(task.objects):
        place = folder / f"{index:03}"
        place.mkdir()
        (place / "collision.obj").write_bytes(shape_obj(obj.shape))
        if looks[obj.name].colored:
            write_ply(looks[obj.name], place / "visual.ply")
        goal = obj.goal
        entries.append(
            {
                "name": obj.name,
                "mesh": f"{index:03}/collision.obj",
                "visual": f"{index:03}/visual.ply" if looks[obj.name].colored else None,
                "mass": obj.mass,
                "friction": obj.friction,
                "pose": goal.pose.matrix.ravel().tolist() if isinstance(goal, At) else None,
                "on": goal.target if isinstance(goal, On) else None,
                "inside": goal.target if isinstance(goal, In) else None,
            }
        )
    return entries
