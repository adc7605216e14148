"""The stream planner: PDDL with streams, for any domain. It knows no robot."""

from tamp.language import Stream
from tamp.planning.constraints import Constraints
from tamp.planning.context import Certified, Context
from tamp.planning.options import Options, Reuse, Settings
from tamp.planning.problem import GroundAction, Problem, Solution, StreamInfo
from tamp.planning.report import Report, SkeletonReport, StreamReport, combined
from tamp.planning.run import PlanningRun
from tamp.planning.search.best_first import Search, SearchResult
from tamp.planning.solve import solve
from tamp.planning.strategies.all_at_once import AllAtOnce
from tamp.planning.strategies.net_benefit import NetBenefit
from tamp.planning.strategies.serialized import Serialized
from tamp.planning.strategies.strategy import Strategy
from tamp.planning.wrappers import (
    from_fn,
    from_gen_fn,
    from_list_fn,
    from_list_gen_fn,
    from_sampler,
    from_stream_map,
    from_test,
)

__all__ = [
    "AllAtOnce", "Certified", "Constraints", "Context", "GroundAction", "NetBenefit", "Options", "PlanningRun",
    "Problem", "Report", "Reuse", "Search", "SearchResult", "Serialized", "Settings", "SkeletonReport", "Solution",
    "Strategy", "Stream", "StreamInfo", "StreamReport", "combined", "from_fn", "from_gen_fn", "from_list_fn",
    "from_list_gen_fn", "from_sampler", "from_stream_map", "from_test", "solve",
]  # fmt: skip
