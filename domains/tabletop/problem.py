"""From a task in its world to a planning problem: initial facts, goal, samplers."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from tamp.domains.tabletop.flatness import Flatness
from tamp.planning import Problem, StreamInfo
from tamp.streams.falls import may_fall
from tamp.streams.grasps import sample_grasp
from tamp.streams.nudges import nudgeable
from tamp.streams.regrasps import regrasping, sample_regrasp
from tamp.streams.values import Configuration, Grasp, Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import At, In, Object, On

Fact = tuple[Any, ...]

FOLDER = Path(str(files("tamp"))) / "domains" / "tabletop"
DOMAIN = FOLDER / "domain.pddl"
STREAMS = FOLDER / "stream.pddl"

DEFAULT_SAMPLERS = {
    "sample-grasp": "tamp.streams.grasps:sample_grasp",
    "sample-placement": "tamp.streams.placements:sample_placement",
    "sample-stacking": "tamp.streams.placements:sample_stacking",
    "sample-insertion": "tamp.streams.placements:sample_insertion",
    "inverse-kinematics": "tamp.streams.reachability:inverse_kinematics",
    "sample-regrasp": "tamp.streams.regrasps:sample_regrasp",
    "regrasp-kinematics": "tamp.streams.reachability:inverse_kinematics",
    "plan-bringing": "tamp.streams.laying:plan_bringing",
    "plan-laying": "tamp.streams.laying:plan_laying",
    "sample-put-aside": "tamp.streams.laid_aside:sample_put_aside",
    "sample-laid-aside": "tamp.streams.laid_aside:sample_laid_aside",
    "plan-sliding": "tamp.streams.sliding:plan_sliding",
    "plan-toppling": "tamp.streams.toppling:plan_toppling",
    "sample-exposed-grasp": "tamp.streams.exposed:sample_exposed_grasp",
    "plan-nudging": "tamp.streams.nudging:plan_nudging",
    "plan-free-motion": "tamp.streams.motions:plan_free_motion",
    "plan-holding-motion": "tamp.streams.motions:plan_holding_motion",
    "test-cfree-placements": "tamp.streams.collisions:test_cfree_placements",
    "test-cfree-handling": "tamp.streams.collisions:test_cfree_handling",
    "test-cfree-slide": "tamp.streams.sliding:test_cfree_slide",
}

LAYING_EFFORT = 5.0  # in calls of another stream, so that an object is rather put down than laid down


def tabletop_problem(
    workspace: Workspace,
    samplers: Mapping[str, Callable[..., Any]],
    configuration: Configuration,
    held: tuple[str, Grasp] | None = None,
    movable: Container[str] | None = None,
    regrasped: Container[str] = (),
    deadline: float = math.inf,
) -> Problem:
    """The planning problem of a workspace as it is now.

    Args:
        workspace: what stands where, and where it shall stand.
        samplers: one function for each stream of stream.pddl.
        configuration: where the arm is.
        held: the object in the hand and its grasp, or None.
        movable: objects that may be moved; None for all.
        regrasped: those of them with a goal pose that shall reach it only by way of another placement and grasp.
        deadline: of the search, on the clock of time.monotonic [s].
    """
    flatness = Flatness(workspace, samplers["sample-grasp"] is sample_grasp, deadline)
    return Problem(
        domain=DOMAIN,
        streams=STREAMS,
        samplers=_consistent(samplers),
        init=[
            *_robot_facts(configuration, held),
            *_object_facts(workspace, movable, regrasped, flatness),
            *_goal_facts(workspace, regrasped, flatness),
        ],
        goal=_goal(workspace),
        scene=workspace,
        info={
            "sample-placement": StreamInfo(fresh=True),
            "sample-regrasp": StreamInfo(fresh=True),
            "sample-put-aside": StreamInfo(fresh=True),
            "sample-laid-aside": StreamInfo(fresh=True),
            "test-cfree-placements": StreamInfo(eager=True),
            "plan-laying": StreamInfo(cost=LAYING_EFFORT),
        },
    )


def regrasping_problem(
    workspace: Workspace, samplers: Mapping[str, Callable[..., Any]], configuration: Configuration
) -> Problem:
    """The same where whatever has a goal pose shall be regrasped on its way."""
    moving = {name for name, goal in workspace.goals.items() if goal != workspace.start[name]}
    return tabletop_problem(workspace, samplers, configuration, regrasped=moving)


VARIANTS = (regrasping_problem,)


def _consistent(samplers: Mapping[str, Callable[..., Any]]) -> dict[str, Callable[..., Any]]:
    """The samplers; where grasps are a researcher's own, so are those that an object is regrasped by."""
    own = samplers["sample-grasp"] is not sample_grasp and samplers["sample-regrasp"] is sample_regrasp
    return {**samplers, "sample-regrasp": regrasping(samplers["sample-grasp"])} if own else dict(samplers)


def _robot_facts(configuration: Configuration, held: tuple[str, Grasp] | None) -> Iterator[Fact]:
    yield ("Conf", configuration)
    yield ("AtConf", configuration)
    if held is None:
        yield ("HandEmpty",)
    else:
        yield ("Grasp", *held)
        yield ("AtGrasp", *held)


def _object_facts(
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


def _goal_facts(workspace: Workspace, regrasped: Container[str], flatness: Flatness) -> Iterator[Fact]:
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


def _goal(workspace: Workspace) -> tuple[Any, ...]:
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
