"""The metrics by name: the paper's, which ranks, and those of OCRTOC's own programs, which differ from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tamp.errors import TampError, meant
from tamp.scoring.ede import ede, mean_edge, upper_error_bound
from tamp.scoring.ocrtoc2020 import symmetric_error
from tamp.scoring.ocrtoc2021 import BOUND_M, surface_error
from tamp.scoring.ocrtoc2024 import IN_PLACE, overlap_error
from tamp.task.model import Object
from tamp.task.pose import Pose


@dataclass(frozen=True)
class Metric:
    """How far an object is from its goal.

    Attributes:
        name: what it is called by.
        unit: "m", or "" for a share.
        error: of an object, from the pose where it is and the pose where it should be; not capped.
        bound: the most that an object may count for.
        interchange: whether objects of one shape may take each other's goals, the best assignment counting.
        tolerance: where given, an object counts 0 for an error below it and the bound for any other.
    """

    name: str
    unit: str
    error: Callable[[Object, Pose, Pose], float]
    bound: Callable[[Object], float]
    interchange: bool = False
    tolerance: float | None = None

    def counted(self, error: float, bound: float) -> float:
        """What an error counts for."""
        if self.tolerance is None:
            return min(error, bound)
        return 0.0 if error < self.tolerance else bound


def _ede(thing: Object, solution: Pose, goal: Pose) -> float:
    return ede(mean_edge(thing.shape), solution, goal)


def _ueb(thing: Object) -> float:
    return upper_error_bound(thing.shape)


EDE = Metric("ede", "m", _ede, _ueb)
OCRTOC_2020 = Metric("ocrtoc2020", "m", symmetric_error, _ueb)
OCRTOC_2021 = Metric("ocrtoc2021", "m", surface_error, lambda thing: BOUND_M, interchange=True)
OCRTOC_2024 = Metric("ocrtoc2024", "", overlap_error, lambda thing: 1.0, interchange=True, tolerance=1.0 - IN_PLACE)

METRICS = (EDE, OCRTOC_2020, OCRTOC_2021, OCRTOC_2024)


def metric(name: str) -> Metric:
    """The metric called `name`.

    Raises:
        TampError: where there is none; says which there are.
    """
    for candidate in METRICS:
        if candidate.name == name:
            return candidate
    names = [m.name for m in METRICS]
    raise TampError(f"unknown metric {name!r}; {meant(name, names)}valid are {', '.join(names)}")
