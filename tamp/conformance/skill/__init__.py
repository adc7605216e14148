"""The kit for skills: does what a skill says outside the PDDL agree with that, and do the checker's rules look?"""

from tamp.conformance.skill.kit import check_skill

__all__ = ["check_skill"]
