"""The stream planner: PDDL with streams, for any domain. It knows no robot."""

from tamp.language import Stream
from tamp.planning.adapters import (
    from_fn,
    from_gen_fn,
    from_list_fn,
    from_list_gen_fn,
    from_sampler,
    from_stream_map,
    from_test,
)
from tamp.planning.constraints import Constraints, Reuse
from tamp.planning.context import Context
from tamp.planning.outputs import Certified
from tamp.planning.problem import GroundAction, Problem, Solution, StreamInfo
from tamp.planning.report import Report, SkeletonReport, StreamReport, combined
from tamp.planning.search import Search, SearchResult
from tamp.planning.solve import solve

__all__ = [
    "Certified", "Constraints", "Context", "GroundAction", "Problem", "Report", "Reuse", "Search", "SearchResult",
    "SkeletonReport", "Solution", "Stream", "StreamInfo", "StreamReport", "combined", "from_fn", "from_gen_fn",
    "from_list_fn", "from_list_gen_fn", "from_sampler", "from_stream_map", "from_test", "solve",
]  # fmt: skip
