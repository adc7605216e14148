"""Shake what is in the hand: a skill as a stranger writes it from the manual alone."""

from pathlib import Path

from tamp.domains import tabletop
from tamp.domains.skill import SAMPLED, FactChange, Skill
from tamp.domains.timing import held
from tamp.task import Action

FOLDER = Path(__file__).parent


def steps(timing, action):
    """One motion of the arm with the object in the hand."""
    obj, grasp, _, motion = action.args
    return Action("shake", (obj,), (timing.move("transfer", motion.points, grasp.width, held=held(obj, grasp)),))


SHAKE = Skill(
    name="shake",
    actions=("shake",),
    domain=FOLDER / "domain.pddl",
    streams=FOLDER / "stream.pddl",
    samplers={"plan-shake": "shaking.sampler:plan_shake"},
    info={"plan-shake": SAMPLED},
    steps=steps,
    facts=lambda action: FactChange(added=(("shaken", action.arguments[0]),)),
    rules="shaking.rules:RULES",
    words={"shake": "shake {0}"},
)
DOMAIN = tabletop.DOMAIN.extended(SHAKE, name="shaking", strategy="all-at-once")
