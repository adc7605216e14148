"""The kits for what is swapped behind the planner: searches and strategies."""

from tamp.conformance.planner.search import check_search
from tamp.conformance.planner.strategy import check_strategy

__all__ = ["check_search", "check_strategy"]
