"""The independent plan checker: from task and plan alone, with its own kinematics and python-fcl."""

from tamp.checking.check import check
from tamp.checking.tolerances import Tolerances
from tamp.checking.verdict import Problem, Verdict

__all__ = ["Problem", "Tolerances", "Verdict", "check"]
