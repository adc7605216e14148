"""Moving: the arm goes from one configuration to another, with an empty hand or holding an object."""

from __future__ import annotations

from pathlib import Path

from tamp.domains.skill import SAMPLED, SceneChange, Skill
from tamp.domains.timing import Timing, held
from tamp.planning import GroundAction
from tamp.task import Action

FOLDER = Path(__file__).parent


def steps(timing: Timing, action: GroundAction) -> Action:
    """One motion along the path that the stream has found."""
    if action.name == "move-free":
        start, goal, path = action.args
        return Action("move", (), (timing.move("transit", path.points, min(start.opening, goal.opening)),))
    obj, grasp, _, _, path = action.args
    return Action("move", (obj,), (timing.move("transfer", path.points, grasp.width, held(obj, grasp)),))


def effect(action: GroundAction) -> SceneChange:
    """The arm is where it was to go."""
    return SceneChange(action.args[1] if action.name == "move-free" else action.args[3])


MOVE = Skill(
    name="move",
    actions=("move-free", "move-holding"),
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={
        "plan-free-motion": "tamp.streams.motion.paths:plan_free_motion",
        "plan-holding-motion": "tamp.streams.motion.paths:plan_holding_motion",
    },
    info={"plan-free-motion": SAMPLED, "plan-holding-motion": SAMPLED},
    steps=steps,
    effect=effect,
    words={"move": "move"},
)
