"""From a task in its world to a planning problem: its facts, its goal, and the samplers."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from tamp.domains.tabletop.facts import goal, goal_facts, object_facts, robot_facts
from tamp.domains.tabletop.flatness import Flatness
from tamp.planning import Problem, StreamInfo
from tamp.streams.grasps import sample_grasp
from tamp.streams.regrasps import regrasping, sample_regrasp
from tamp.streams.values import Configuration, Grasp
from tamp.streams.workspace import Workspace

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
            *robot_facts(configuration, held),
            *object_facts(workspace, movable, regrasped, flatness),
            *goal_facts(workspace, regrasped, flatness),
        ],
        goal=goal(workspace),
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
