"""Picking and placing: an object is taken from the table or from what it stands on, and put down on either."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tamp.domains.skill import FRESH, SAMPLED, Fact, Question, SceneChange, Skill
from tamp.domains.tabletop.handling import put_down, put_down_effect, take, take_effect
from tamp.domains.timing import Timing
from tamp.planning import GroundAction
from tamp.streams.affordances.flat_faces import flat_faces
from tamp.streams.affordances.topple_path import to_be_pushed
from tamp.streams.workspace import TABLE, Workspace
from tamp.task import Action, In, On

FOLDER = Path(__file__).parent


def affordances(workspace: Workspace, question: Question) -> Iterator[Fact]:
    """What may be taken, and where it may be put."""
    for name in workspace.start:
        if question.may_move(name) and name not in question.regrasped:
            yield ("Movable", name)
            if not flat_faces(workspace, name) or to_be_pushed(workspace, name, workspace.start[name]):
                yield ("Placeable", name, TABLE)
    regions = {region.name for region in workspace.task.regions}
    for obj in workspace.task.objects:
        match obj.goal:
            case On(target) if target in regions or target == TABLE:
                yield ("Placeable", obj.name, target)
            case On(target):
                yield ("Stackable", obj.name, target)
            case In(target):
                yield ("Insertable", obj.name, target)


def steps(timing: Timing, action: GroundAction) -> Action:
    """Approach, grip and lift; or lower, release and retreat."""
    return take(timing, action) if action.name in ("pick", "unstack") else put_down(timing, action)


def effect(action: GroundAction) -> SceneChange:
    """The object is in the hand, or where it was put."""
    return take_effect(action) if action.name in ("pick", "unstack") else put_down_effect(action)


PICK_AND_PLACE = Skill(
    name="pick-and-place",
    actions=("pick", "unstack", "place", "stack"),
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={
        "sample-grasp": "tamp.streams.grasping.sampler:sample_grasp",
        "sample-placement": "tamp.streams.placing.sampler:sample_placement",
        "sample-stacking": "tamp.streams.placing.sampler:sample_stacking",
        "sample-insertion": "tamp.streams.placing.sampler:sample_insertion",
        "inverse-kinematics": "tamp.streams.motion.inverse_kinematics:inverse_kinematics",
        "balance-without": "tamp.streams.affordances.stack_balance:balance_without",
        "balance-with": "tamp.streams.affordances.stack_balance:balance_with",
    },
    info={
        "sample-grasp": SAMPLED,
        "sample-placement": FRESH,
        "sample-stacking": SAMPLED,
        "sample-insertion": SAMPLED,
        "inverse-kinematics": SAMPLED,
    },
    affordances=affordances,
    steps=steps,
    effect=effect,
    words={
        "pick": "pick {0} from {rest}",
        "unstack": "unstack {0} from {rest}",
        "place": "place {0} on {rest}",
        "stack": "stack {0} on {rest}",
    },
)
