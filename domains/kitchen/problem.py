"""From a workspace and its regions to a planning problem of cooking and cleaning."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from tamp.domains import tabletop
from tamp.planning import Problem
from tamp.streams.values import Configuration
from tamp.streams.workspace import TABLE, Workspace

FOLDER = Path(str(files("tamp"))) / "domains" / "kitchen"

DEFAULT_SAMPLERS = {
    stream: tabletop.DEFAULT_SAMPLERS[stream]
    for stream in (
        "sample-grasp", "sample-placement", "inverse-kinematics", "plan-free-motion", "plan-holding-motion",
        "test-cfree-placements", "test-cfree-handling",
    )
}  # fmt: skip


def kitchen_problem(
    workspace: Workspace,
    samplers: Mapping[str, Callable[..., Any]],
    configuration: Configuration,
    *,
    sinks: Iterable[str] = (),
    stoves: Iterable[str] = (),
    cleaned: Iterable[str] = (),
    cooked: Iterable[str] = (),
) -> Problem:
    """The planning problem of a kitchen.

    Args:
        workspace: what stands where, all of it on the table.
        samplers: one function for each stream of stream.pddl.
        configuration: where the arm is; the hand is empty.
        sinks: regions where things can be cleaned.
        stoves: regions where clean things can be cooked.
        cleaned: objects that shall be clean at the end.
        cooked: objects that shall be cooked at the end.
    """
    places = {TABLE, *(region.name for region in workspace.task.regions)}
    init: list[tuple[Any, ...]] = [("Conf", configuration), ("AtConf", configuration), ("HandEmpty",)]
    init += [*(("Sink", name) for name in sinks), *(("Stove", name) for name in stoves)]
    init += _object_facts(workspace, sorted(places))
    goal = [*(("Cleaned", name) for name in cleaned), *(("Cooked", name) for name in cooked), ("HandEmpty",)]
    return Problem(
        domain=FOLDER / "domain.pddl",
        streams=FOLDER / "stream.pddl",
        samplers=dict(samplers),
        init=init,
        goal=("and", *goal),
        scene=workspace,
    )


def _object_facts(workspace: Workspace, places: list[str]) -> Iterator[tuple[Any, ...]]:
    for name, placement in workspace.start.items():
        yield ("Movable", name)
        yield from (("Placeable", name, place) for place in places)
        yield ("Placement", name, placement)
        yield ("AtPose", name, placement)
