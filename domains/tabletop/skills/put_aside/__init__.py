"""Putting aside what would lie too flat for any hand on some face: grasp and place are chosen together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from tamp.domains.skill import FRESH, Fact, Question, Skill
from tamp.domains.tabletop.skills.tilted_release import EFFORT
from tamp.streams.affordances.flat_faces import flat_faces
from tamp.streams.affordances.topple_path import to_be_pushed
from tamp.streams.workspace import Workspace

FOLDER = Path(__file__).parent


def affordances(workspace: Workspace, question: Question) -> Iterator[Fact]:
    """Which objects need such care; for itself alone an object need not step aside."""
    for name, placement in workspace.start.items():
        if not question.may_move(name) or name in question.regrasped:
            continue
        others_move = any(question.may_move(other) for other in workspace.start if other != name)
        if question.movable is not None and not others_move:
            continue
        if flat_faces(workspace, name) and not to_be_pushed(workspace, name, placement):
            yield ("LiesFlat", name, placement)


PUT_ASIDE = Skill(
    name="put-aside",
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={
        "sample-put-aside": "tamp.streams.placing.put_aside:sample_put_aside",
        "sample-laid-aside": "tamp.streams.placing.put_aside:sample_laid_aside",
        "sample-exposed-aside": "tamp.streams.placing.put_aside:sample_exposed_aside",
    },
    info={
        "sample-put-aside": FRESH,
        "sample-laid-aside": replace(FRESH, cost=EFFORT),
        "sample-exposed-aside": replace(FRESH, cost=EFFORT),
    },
    affordances=affordances,
)
