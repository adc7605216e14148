"""What the planner is told of a workspace: what stands where, what may be done with it, and what shall be true."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from typing import Any

from tamp.domains.tabletop.flatness import Flatness
from tamp.streams.falls import may_fall
from tamp.streams.nudges import nudgeable
from tamp.streams.values import Configuration, Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import At, In, Object, On

Fact = tuple[Any, ...]


def robot_facts(configuration: Configuration, held: tuple[str, Grasp] | None) -> Iterator[Fact]:
    """Where the arm is and what its hand holds, if anything."""
    yield ("Conf", configuration)
    yield ("AtConf", configuration)
    if held is None:
        yield ("HandEmpty",)
    else:
        yield ("Grasp", *held)
        yield ("AtGrasp", *held)


def object_facts(
    workspace: Workspace, movable: Container[str] | None, regrasped: Container[str], flatness: Flatness
) -> Iterator[Fact]:
    """Where objects are, and how they may be put aside."""
    for name, placement in workspace.start.items():
        pushed = list(_push_facts(name, placement, flatness)) if movable is None or name in movable else []
        yield from pushed
        if name in regrasped:
            yield ("Regrasped", name, placement, workspace.goals[name])
        elif movable is None or name in movable:
            yield ("Movable", name)
            if pushed or not flatness.lies_flat(name):
                yield ("Placeable", name, TABLE)
            elif movable is None or any(other in movable for other in workspace.start if other != name):
                yield ("LiesFlat", name, placement)  # for itself alone it need not step aside
        yield from _placement_facts(workspace.start, name, placement)
        yield ("AtPose", name, placement)
        for region in workspace.task.regions:
            if TABLE in placement.on and _centre_inside(region, placement):
                yield ("InRegion", name, placement, region.name)
    yield ("Region", TABLE)
    for region in workspace.task.regions:
        yield ("Region", region.name)


def _push_facts(name: str, placement: Placement, flatness: Flatness) -> Iterator[Fact]:
    """How an object can be pushed to where a hand can take it, if none can at a placement."""
    if flatness.slidable(name, placement):
        yield ("Slidable", name, placement)
    if flatness.topplable(name, placement):
        yield ("Topplable", name, placement)


def goal_facts(workspace: Workspace, regrasped: Container[str], flatness: Flatness) -> Iterator[Fact]:
    """What is true of where objects shall stand, as poses or on what."""
    regions = {region.name for region in workspace.task.regions}
    for name, placement in workspace.goals.items():
        if placement != workspace.start[name]:
            facts = _placement_facts({**workspace.start, **workspace.goals}, name, placement)
            if any(_push_facts(name, placement, flatness)):  # no hand can put it down there
                facts = (fact for fact in facts if fact[0] not in ("OnTable", "PutOnTable"))
            yield from facts
            if placement.on == (TABLE,):
                yield ("LaidOnTable", name, placement)
            if nudgeable(workspace, name, workspace.start[name], placement):
                yield ("Nudgeable", name, workspace.start[name], placement)
            if name not in regrasped and may_fall(workspace, name, placement):
                yield ("Layable", name, placement)
    for obj in workspace.task.objects:
        match obj.goal:
            case On(target) if target in regions or target == TABLE:
                yield ("Placeable", obj.name, target)
            case On(target):
                yield ("Stackable", obj.name, target)
            case In(target):
                yield ("Insertable", obj.name, target)


def _placement_facts(around: Mapping[str, Placement], name: str, placement: Placement) -> Iterator[Fact]:
    """What is certified of a placement whose supports stand as `around` says."""
    yield ("Placement", name, placement)
    supports = [support for support in placement.on if support != TABLE]
    if not supports:
        yield ("OnTable", name, placement)
        yield ("PutOnTable", name, placement)
    for support in supports:
        yield ("RestsOn", name, placement, support, around[support])


def goal(workspace: Workspace) -> tuple[Any, ...]:
    """What shall be true in the end: every goal, and an empty hand."""
    return (
        "and",
        *(_goal_of(workspace, obj) for obj in workspace.task.objects if obj.goal is not None),
        ("HandEmpty",),
    )


def _goal_of(workspace: Workspace, obj: Object) -> Fact:
    match obj.goal:
        case At():
            return ("AtPose", obj.name, workspace.goals[obj.name])
        case On(target):
            return ("On", obj.name, target)
        case In(target):
            return ("In", obj.name, target)
    raise ValueError(f"{obj.name} has no goal")


def _centre_inside(region: Any, placement: Placement) -> bool:
    offsets = (placement.pose.xyz[0] - region.center[0], placement.pose.xyz[1] - region.center[1])
    return all(abs(offset) <= size / 2 for offset, size in zip(offsets, region.size, strict=True))
