"""The independent plan checker: from task and plan alone, with its own kinematics and python-fcl."""

from tamp.checking.actions.rule import ActionRule
from tamp.checking.check import check
from tamp.checking.tolerances import Tolerances
from tamp.checking.verdict import Problem, Verdict

__all__ = ["ActionRule", "Problem", "Tolerances", "Verdict", "check"]
