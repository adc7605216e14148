"""The stream planner: PDDL with streams, for any domain. It knows no robot."""

from tamp.language import Stream
from tamp.planning.constraints import Constraints, Reuse
from tamp.planning.context import Context
from tamp.planning.problem import GroundAction, Problem, Solution, StreamInfo
from tamp.planning.report import Report, SkeletonReport, StreamReport
from tamp.planning.sampling import Certified
from tamp.planning.search import Search, SearchResult
from tamp.planning.solve import solve

__all__ = [
    "Certified", "Constraints", "Context", "GroundAction", "Problem", "Report", "Reuse", "Search", "SearchResult",
    "SkeletonReport", "Solution", "Stream", "StreamInfo", "StreamReport", "solve",
]  # fmt: skip
