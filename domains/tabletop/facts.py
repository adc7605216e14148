"""What stands where and shall stand where: the facts that all skills of the tabletop share.

Facts depend on the task's geometry alone: never on whose function serves a stream, nor on the time that is left.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from tamp.domains.skill import Fact, Question, Skill
from tamp.planning import StreamInfo
from tamp.streams.affordances.stack_balance import needed_below
from tamp.streams.affordances.topple_path import to_be_pushed
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import At, In, Object, On, Region

FOLDER = Path(__file__).parent


def facts(workspace: Workspace, question: Question) -> Iterator[Fact]:
    """What is known of the arm, of objects where they stand, and of where they shall stand."""
    yield ("Conf", question.configuration)
    yield ("AtConf", question.configuration)
    if question.held is None:
        yield ("HandEmpty",)
    else:
        yield ("Grasp", *question.held)
        yield ("AtGrasp", *question.held)
    for name, placement in workspace.start.items():
        wanted = _wanted_below(workspace.task.object(name))
        leaving = [lower for lower in placement.on if question.may_move(lower) and lower not in wanted]
        yield from _placement_facts(workspace.start, name, placement, needed_below(workspace, name, leaving))
        yield ("AtPose", name, placement)
        if question.may_move(name):
            yield ("MayMove", name)
        for region in workspace.task.regions:
            if TABLE in placement.on and _centre_inside(workspace, region, name, placement):
                yield ("InRegion", name, placement, region.name)
    yield ("Region", TABLE)
    yield from (("Region", region.name) for region in workspace.task.regions)
    for name, goal in workspace.goals.items():
        if goal != workspace.start[name] and question.may_move(name):
            around = {**workspace.start, **workspace.goals}
            about = _placement_facts(around, name, goal, goal.on)
            if to_be_pushed(workspace, name, goal):  # no hand can put it down there
                about = (fact for fact in about if fact[0] not in ("OnTable", "PutOnTable"))
            yield from about


def _wanted_below(obj: Object) -> tuple[str, ...]:
    """What an object shall be on or in: where it touches that, it is, whether or not it needs it to stay there."""
    return (obj.goal.target,) if isinstance(obj.goal, On | In) else ()


def _placement_facts(
    around: Mapping[str, Placement], name: str, placement: Placement, below: Sequence[str]
) -> Iterator[Fact]:
    """What is certified of a placement that needs what is below it, which stands as `around` says."""
    yield ("Placement", name, placement)
    supports = [support for support in below if support != TABLE]
    if not supports:
        yield ("OnTable", name, placement)
        yield ("PutOnTable", name, placement)
    for support in supports:
        yield ("RestsOn", name, placement, support, around[support])


def goal(workspace: Workspace) -> Iterator[Fact]:
    """What shall be true in the end: every object's goal, and an empty hand."""
    yield from (_goal_of(workspace, obj) for obj in workspace.task.objects if obj.goal is not None)
    yield ("HandEmpty",)


def _goal_of(workspace: Workspace, obj: Object) -> Fact:
    match obj.goal:
        case At():
            return ("AtPose", obj.name, workspace.goals[obj.name])
        case On(target):
            return ("On", obj.name, target)
        case In(target):
            return ("In", obj.name, target)
    raise ValueError(f"{obj.name} has no goal")


def _centre_inside(workspace: Workspace, region: Region, name: str, placement: Placement) -> bool:
    """Whether the middle of the box round an object is over a region: its origin may be anywhere."""
    low, high = workspace.bounds(name, placement.pose)
    middle = (low + high) / 2
    sides = zip(middle, region.center, region.size, strict=False)
    return all(abs(value - center) <= size / 2 for value, center, size in sides)


TABLETOP = Skill(
    name="tabletop",
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={
        "test-cfree-placements": "tamp.streams.collisions:test_cfree_placements",
        "test-cfree-handling": "tamp.streams.motion.handling_contacts:test_cfree_handling",
    },
    info={"test-cfree-placements": StreamInfo(eager=True)},
    affordances=facts,
    rules="tamp.checking.actions.tabletop:TABLETOP",
)
