"""The skills of the tabletop, a folder each: PDDL, streams, and the object that says the rest.

May import streams, world, planning, language, task, and tamp.domains.skill.
"""

from tamp.domains.tabletop.skills.move import MOVE
from tamp.domains.tabletop.skills.nudge import NUDGE
from tamp.domains.tabletop.skills.pick_and_place import PICK_AND_PLACE
from tamp.domains.tabletop.skills.push import PUSH
from tamp.domains.tabletop.skills.put_aside import PUT_ASIDE
from tamp.domains.tabletop.skills.regrasp import REGRASP
from tamp.domains.tabletop.skills.slide import SLIDE
from tamp.domains.tabletop.skills.tilted_release import TILTED_RELEASE
from tamp.domains.tabletop.skills.topple import TOPPLE

SKILLS = (MOVE, PICK_AND_PLACE, TILTED_RELEASE, REGRASP, PUT_ASIDE, PUSH, SLIDE, TOPPLE, NUDGE)

__all__ = [
    "MOVE", "NUDGE", "PICK_AND_PLACE", "PUSH", "PUT_ASIDE", "REGRASP", "SKILLS", "SLIDE", "TILTED_RELEASE", "TOPPLE",
]  # fmt: skip
