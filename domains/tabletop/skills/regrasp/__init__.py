"""Regrasping: an object is put down on its way, so that it reaches its goal by another grasp than it was taken by."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tamp.domains.skill import FRESH, SAMPLED, Fact, Question, Skill
from tamp.streams.affordances.topple_path import to_be_pushed
from tamp.streams.workspace import Workspace

FOLDER = Path(__file__).parent


def affordances(workspace: Workspace, question: Question) -> Iterator[Fact]:
    """Which objects shall or may be regrasped, as the question says, from where a hand can take them."""
    for name, placement in workspace.start.items():
        if name in question.regrasped or name in question.either:
            yield ("RegraspedTo", name, workspace.goals[name])
            if not to_be_pushed(workspace, name, placement):
                yield ("Exposed", name, placement)


REGRASP = Skill(
    name="regrasp",
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={
        "sample-regrasp": "tamp.streams.placing.regrasp:sample_regrasp",
        "regrasp-kinematics": "tamp.streams.motion.inverse_kinematics:inverse_kinematics",
    },
    info={"sample-regrasp": FRESH, "regrasp-kinematics": SAMPLED},
    affordances=affordances,
)
