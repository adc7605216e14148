"""What became of each object, told from the truth after a run: seen, estimated, grasped or placed wrongly?"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tamp.perception.belief.belief import Belief
from tamp.perception.estimation.assignment import assigned
from tamp.perception.estimation.models.object_model import ObjectModel, object_model
from tamp.perception.evaluation import pose_error
from tamp.perception.rendering.surface import Surface
from tamp.scoring import Score
from tamp.scoring.score import SOLVED_WITHIN_M
from tamp.task import Fall, Grip, Move, Plan, Pose, Release

WRONG = 0.02
"""An estimate farther from the truth than this (EDE over the mesh's symmetries) is wrong [m]."""

APART = 10.0
"""What stands for the distance of an object that was not found [m]."""


@dataclass(frozen=True)
class Outcome:
    """What became of one object.

    Attributes:
        name: the object.
        fate: "reached"; "reached, but turned in a way that its shape does not show"; or why
            not: "not seen", "wrongly estimated", "left by the plan", "not grasped", "wrongly placed"; "no goal" where
            it has none.
        estimate_m: how far the first estimate was off (EDE over the mesh's symmetries) [m]; None: not found.
        raw_m: the same without symmetries.
        confidence: of that estimate, 0..1.
        look: the number of the look that found it, from 0; None: none did.
        end_m: how far it ends from its goal pose (EDE over the mesh's symmetries) [m]; None where it has none.
    """

    name: str
    fate: str
    estimate_m: float | None
    raw_m: float | None
    confidence: float
    look: int | None
    end_m: float | None


def identities(beliefs: Sequence[Belief], start: Mapping[str, Pose], looks: Mapping[str, Surface]) -> dict[str, str]:
    """Believed name -> true one. Objects of one mesh are told apart by nothing: a name is what was first called it.

    Args:
        beliefs: what was believed after each look.
        start: where the objects truly stood when they were first looked at.
        looks: object -> what it looks like.
    """
    kinds: dict[int, list[str]] = {}
    for name, surface in looks.items():
        kinds.setdefault(id(surface), []).append(name)
    names: dict[str, str] = {}
    for group in kinds.values():
        first = [beliefs[0].poses.get(name) if beliefs else None for name in group]
        costs = [[APART if p is None else math.dist(p.xyz, start[other].xyz) for other in group] for p in first]
        names |= {name: group[column] for name, column in zip(group, assigned(np.array(costs)), strict=True)}
    return names


def outcomes(
    beliefs: Sequence[Belief],
    truths: Sequence[Mapping[str, Pose]],
    plans: Sequence[Plan],
    reached: Score,
    looks: Mapping[str, Surface],
    grasped: Mapping[str, int],
    ends: Mapping[str, tuple[Pose, Pose]],
) -> tuple[Outcome, ...]:
    """What became of every object.

    Args:
        beliefs: what was believed after each look.
        truths: where everything truly was at each look, by believed names.
        plans: all plans.
        reached: the score of the end.
        looks: object -> what it looks like.
        grasped: object -> how often it was grasped and held.
        ends: object with a goal pose -> where it is in the end, and that pose.
    """
    brought = {name for plan in plans for name in _brought(plan)}
    found = []
    for name, look in looks.items():
        sight = _sight(name, beliefs, truths, object_model(look))
        end = pose_error(object_model(look), *ends[name])[0] if name in ends else None
        met = reached.goals_met.get(name)
        fate = _symmetric(met, end) or _fate(met, sight, name in brought, grasped.get(name))
        error, raw = sight.errors[0] if sight.errors else (None, None)
        found.append(Outcome(name, fate, error, raw, sight.confidence, sight.look, end))
    return tuple(found)


@dataclass(frozen=True)
class _Sight:
    """What looks said of an object: the errors of all that found it, and of the first its confidence and number."""

    errors: tuple[tuple[float, float], ...]
    confidence: float
    look: int | None


def _sight(name: str, beliefs: Sequence[Belief], truths: Sequence[Mapping[str, Pose]], model: ObjectModel) -> _Sight:
    found = [i for i, belief in enumerate(beliefs) if belief.estimates[name].pose is not None]
    errors: list[tuple[float, float]] = []
    for i in found:
        pose = beliefs[i].estimates[name].pose
        assert pose is not None
        errors.append(pose_error(model, pose, truths[i][name]))
    if not found:
        return _Sight((), 0.0, None)
    return _Sight(tuple(errors), beliefs[found[0]].estimates[name].confidence, found[0])


def _symmetric(met: bool | None, end: float | None) -> str:
    """What became of an object that has its goal pose but for a turn that its shape does not show; else nothing."""
    near = met is False and end is not None and end <= SOLVED_WITHIN_M
    return "reached, but turned in a way that its shape does not show" if near else ""


def _fate(met: bool | None, sight: _Sight, brought: bool, grasped: int | None) -> str:
    if met is None:
        return "no goal"
    if met:
        return "reached"
    if sight.look is None:
        return "not seen"
    if any(error[0] > WRONG for error in sight.errors):
        return "wrongly estimated"
    if not brought:
        return "left by the plan"
    return "not grasped" if grasped == 0 else "wrongly placed"


def _moved(plan: Plan) -> set[str]:
    """Objects that a plan takes into the hand or pushes."""
    gripped = {step.attachment.object for step in plan.steps if isinstance(step, Grip)}
    return gripped | {step.pushed.object for step in plan.steps if isinstance(step, Move) and step.pushed is not None}


def _brought(plan: Plan) -> set[str]:
    """Objects that a plan moves, but for those that it does no more than put aside, away from their goal poses."""
    ends = {step.object: step.pose for step in plan.steps if isinstance(step, Release | Fall)}
    aside = {
        name for name, pose in ends.items() if name in plan.goals and math.dist(pose.xyz, plan.goals[name].xyz) > WRONG
    }
    return _moved(plan) - aside


def as_dicts(found: Sequence[Outcome]) -> tuple[dict[str, Any], ...]:
    """JSON-like mappings, in order."""
    return tuple(vars(outcome) for outcome in found)
