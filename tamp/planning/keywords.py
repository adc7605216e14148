"""What PDDLStream's keywords, planners and algorithms mean here; `solve` takes them beside its own.

A keyword that has no meaning here is accepted: where it asks for something else than it does there by default, a
warning says what this planner does instead.
"""

from __future__ import annotations

import reprlib
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, NamedTuple

from tamp.errors import DomainError, DomainWarning, meant
from tamp.planning.constraints import Constraints
from tamp.planning.problem import Problem, StreamInfo
from tamp.planning.search.fast_downward import CONFIGURATIONS
from tamp.planning.wrappers import from_stream_map

PLANNERS = {
    "dijkstra": "astar",
    "max-astar": "astar-max",
    "lmcut-astar": "astar-lmcut",
    "goal": "ff-greedy",
    "goal-lazy": "ff-greedy",
    "ff-lazy": "ff-greedy",
    "ff-lazy-tiebreak": "ff-greedy",
    "ff-lazy-pref": "ff-greedy",
    "ff-ehc": "ff-greedy",
    "ff-astar": "ff",
    "ff-astar2": "ff",
    "ff-eager-tiebreak": "ff-eager",
    "ff-eager-pref": "ff-eager",
    "ff-wastar1": "ff",
    "ff-wastar2": "ff",
    "ff-wastar3": "ff",
    "ff-wastar4": "ff",
    "ff-wastar5": "ff",
    "ff-x": "ff",
    "lama": "ff",
    "cerberus": "ff",
    "add-random-lazy": "add",
    "cea-wastar1": "cea",
    "cea-wastar3": "cea",
    "cea-wastar5": "cea",
}
"""Planner of PDDLStream -> the search that stands for it. `ff` chooses its weight by the size of the task."""

_ONE_PLAN = "one plan is returned, not several"
_NO_TIME = "actions have no durations here"

PLANNERS_OF_OTHER_KINDS: Mapping[str, tuple[str, str]] = {
    "forbid": ("ff", _ONE_PLAN),
    "kstar": ("astar-lmcut", _ONE_PLAN),
    "symk": ("astar-lmcut", _ONE_PLAN),
    "tfd": ("ff", _NO_TIME),
    "tflap": ("ff", _NO_TIME),
    "optic": ("ff", _NO_TIME),
    "tpshe": ("ff", _NO_TIME),
}
"""Planner of PDDLStream that does more than find a plan -> the search that stands for it, and what it does not do."""

ALGORITHMS = {
    "abstract": "focused",
    "abstract_adaptive": "adaptive",
    "abstract_binding": "binding",
    "abstract_focused": "focused",
    "current": "adaptive",
    "hierarchical": "adaptive",
    "optimistic": "focused",
}
"""Algorithm of PDDLStream -> the one that stands for it, where its name is another."""

SERIALIZED = "serialized"
"""An algorithm of PDDLStream that is a strategy here."""

_BUDGETS = "budgets grow by themselves"
_WHOLE = "a plan is bound as a whole"
_NO_FILES = "no files are left behind"
_SHARED = "search and sampling share the time by the work that they do"
_FORBIDDEN = "use constraints=Constraints(forbidden=[...]) for actions that must not occur"

WITHOUT_MEANING: Mapping[str, tuple[tuple[Any, ...], str]] = {
    "initial_complexity": ((0,), _BUDGETS),
    "start_complexity": ((0,), _BUDGETS),
    "complexity_step": ((1,), _BUDGETS),
    "max_complexity": ((inf,), _BUDGETS),
    "max_skeletons": ((inf, None), _BUDGETS),
    "search_sample_ratio": ((0, 1), _SHARED),
    "search_sampling_ratio": ((0, 1), _SHARED),
    "layers": ((0, 1), _BUDGETS),
    "eager_layers": ((0, 1), _BUDGETS),
    "use_skeleton": ((True,), _WHOLE),
    "action_info": ((), "of an action only its cost counts; what is known of streams is stream_info"),
    "synthesizers": ((), "an :optimizer in the stream file is asked about several streams at once"),
    "postprocess": ((False,), "the first plan is improved for a moment, with a low success_cost till the time is up"),
    "diverse": ((None, False), _ONE_PLAN),
    "max_plans": ((1,), _ONE_PLAN),
    "bind": ((True,), _WHOLE),
    "max_failures": ((0, inf), _BUDGETS),
    "fail_fast": ((True, False), ""),
    "statistics": ((False,), "solution.report.streams has what was counted of each stream"),
    "unit_efforts": ((False,), "efforts are learnt from what streams give"),
    "max_effort": ((inf,), "streams that take much effort are used reluctantly, never left out"),
    "effort_weight": ((None,), "efforts only decide between plans that are equal otherwise"),
    "reorder": ((True,), "streams are ordered by what fails first"),
    "replan_actions": ((), _WHOLE),
    "hierarchy": ((), "the whole domain is planned with at once"),
    "max_restarts": ((0,), "a run does not end before its time, so that nothing is begun anew; try another seed"),
    "iteration_time": ((inf,), "a run does not end before its time, so that nothing is begun anew"),
    "abort": ((True, False), ""),
    "visualize": ((False,), "solution.picture is the plan as graphviz text"),
    "debug": ((False,), "solution.report says what was tried and what failed"),
    "clean": ((True, False), ""),
    "temp_dir": ((None,), _NO_FILES),
    "use_unique": ((False,), "each stream instance has placeholders of its own"),
    "retain_facts": ((True,), "what streams gave is kept from one goal to the next"),
    "subgoal_horizon": ((1,), "the whole domain is planned with at once"),
    "use_probabilities": ((False,), _ONE_PLAN),
    "prohibit_predicates": ((), _FORBIDDEN),
    "prohibit_actions": ((False,), _FORBIDDEN),
}
"""Keyword of PDDLStream's solvers without a meaning here -> values that ask for nothing, and what is done instead."""


class PDDLProblem(NamedTuple):
    """A problem as PDDLStream's scripts write it; `solve` takes one in place of a `Problem`."""

    domain_pddl: Any
    constant_map: Any
    stream_pddl: Any
    stream_map: Any
    init: Any
    goal: Any


WILD = "*"


@dataclass(frozen=True)
class PlanConstraints:
    """What a plan must look like, in PDDLStream's words: its actions with arguments, `WILD` or "?x" for any of them.

    Attributes:
        skeletons: lists of pairs such as `("pick", ["a", WILD, "?g"])`; a plan follows one of them, if any.
        groups: name -> objects, any of which stands for the name in a skeleton.
        exact: whether the plan has the skeleton's actions and no others, moves included; otherwise any others may come
            before, between and after them.
        hint: not supported: a skeleton is always followed.
        max_cost: plans that cost more do not count.
    """

    skeletons: Any = None
    groups: Mapping[str, Any] = field(default_factory=dict)
    exact: bool = True
    hint: bool = False
    max_cost: float = inf


def problem_of(given: Any, stream_info: Mapping[str, StreamInfo] | None = None) -> Problem:
    """The problem of a `PDDLProblem`, or of any six values in its order; a `Problem` with what is known of its streams.

    Raises:
        DomainError: where something else is given.
        SamplerError: where the stream map does not fit the streams.
    """
    problem = given
    if not isinstance(problem, Problem):
        if not isinstance(given, tuple | list) or len(given) != 6:
            names = ", ".join(PDDLProblem._fields)
            raise DomainError(f"expected a Problem, or a PDDLProblem of ({names}), found {type(given).__name__}")
        domain, constants, streams, stream_map, init, goal = given
        samplers = from_stream_map({} if stream_map is None else stream_map)
        problem = Problem(domain, streams, samplers, init, goal, constants=constants or {})
    if stream_info:
        problem = replace(problem, info={**problem.info, **_known(problem, stream_info)})
    return problem


def _known(problem: Problem, stream_info: Mapping[str, StreamInfo]) -> Mapping[str, StreamInfo]:
    parsed = problem.parsed_streams
    names = {s.name for s in parsed.streams} | {f.name for f in parsed.functions} | {p.name for p in parsed.predicates}
    for name in sorted(stream_info.keys() - names):
        if name.lower() not in names:
            _warn(f"stream_info names {name!r}, which is no stream and is ignored; {meant(name, names)}".rstrip("; "))
    return {name: _info(info) for name, info in stream_info.items() if name.lower() in names}


def _info(given: Any) -> StreamInfo:
    """What is known of a stream, which PDDLStream's own class may say."""
    if isinstance(given, StreamInfo):
        return given
    overhead, odds = (getattr(given, name, None) for name in ("overhead", "p_success"))
    return StreamInfo(
        eager=bool(getattr(given, "eager", False)),
        p_success=odds if isinstance(odds, int | float) else 1.0,
        overhead=overhead if isinstance(overhead, int | float) else None,
    )


def search_of(planner: str) -> str:
    """The search that a name stands for, which may be one of PDDLStream's planners.

    Raises:
        DomainError: where neither has such a name.
    """
    if planner in PLANNERS_OF_OTHER_KINDS:
        search, instead = PLANNERS_OF_OTHER_KINDS[planner]
        _warn(f"planner={planner!r} is {search!r} here: {instead}")
        return search
    ours, theirs = ("builtin", *CONFIGURATIONS), (*PLANNERS, *PLANNERS_OF_OTHER_KINDS)
    if planner not in (*ours, *theirs):
        raise DomainError(
            f"unknown search {planner!r}; {meant(planner, (*ours, *theirs))}there are: {', '.join(ours)}; and by "
            f"PDDLStream's names: {', '.join(theirs)}"
        )
    return PLANNERS.get(planner, planner)


def algorithm_of(name: str) -> str:
    """The algorithm that a name stands for, which may be one of PDDLStream's."""
    return ALGORITHMS.get(name.replace("-", "_"), name) if isinstance(name, str) else name


def constraints_of(given: Any) -> tuple[Constraints | None, float]:
    """Our constraints of PDDLStream's, and the most that a plan may cost by them.

    Raises:
        DomainError: where they are no constraints, or groups no mapping of names to objects.
    """
    if given is None or isinstance(given, Constraints):
        return given, inf
    if not hasattr(given, "skeletons"):
        raise DomainError(f"constraints is {given!r}; valid are Constraints, PlanConstraints and None")
    if getattr(given, "hint", False):
        _warn("PlanConstraints: hint has no effect, the skeleton is followed")
    skeletons = tuple(tuple(_patterns(skeleton, given.exact)) for skeleton in given.skeletons or ())
    groups = given.groups or {}
    if not isinstance(groups, Mapping) or not all(isinstance(objects, Iterable) for objects in groups.values()):
        raise DomainError(f"PlanConstraints: expected groups such as {{'block': ['a', 'b']}}, found {groups!r}")
    groups = {name: tuple(objects) for name, objects in groups.items()}
    exact = bool(given.exact)
    return Constraints(skeletons=skeletons, groups=groups, exact=exact) if skeletons else None, given.max_cost


def _patterns(skeleton: Any, exact: bool) -> Iterator[Any]:
    for name, args in skeleton:
        yield from () if exact else (...,)
        yield (name, *(... if isinstance(arg, str) and arg == WILD else arg for arg in args))
    yield from () if exact else (...,)


def understood(given: Mapping[str, Any]) -> dict[str, Any]:
    """PDDLStream's keywords that have a meaning here, after a warning about each of the others.

    Raises:
        TypeError: for a keyword that neither knows.
    """
    meaningful = {}
    for name, value in given.items():
        if name in MEANINGFUL:
            meaningful[name] = value
        elif name not in WITHOUT_MEANING:
            hint = meant(name, (*OWN, *MEANINGFUL, *WITHOUT_MEANING), alike=0.75)
            raise TypeError(
                f"solve: unexpected keyword {name!r}; {hint}there are: {', '.join(OWN)}; of PDDLStream's: "
                f"{', '.join(MEANINGFUL)}; and without effect: {', '.join(WITHOUT_MEANING)}"
            )
        else:
            usual, instead = WITHOUT_MEANING[name]
            if not (value in usual or (hasattr(value, "__len__") and not len(value))):
                _warn(
                    f"{name}={reprlib.repr(value)} has no effect here: {instead}"
                    if instead
                    else f"{name} has no effect here"
                )
    return meaningful


MEANINGFUL = ("planner", "max_time", "max_planner_time", "stream_info", "verbose")
"""Keywords of PDDLStream's solvers that `solve` knows by another name, or beside its own."""

OWN = (
    "algorithm", "timeout", "seed", "max_cost", "success_cost", "unit_costs", "search", "max_iterations", "max_memory",
    "constraints", "reuse", "strategy",
)  # fmt: skip
"""The keywords of `solve` itself."""


_PACKAGE = __name__.rpartition(".")[0]


def _warn(message: str) -> None:
    """A warning about the first line outside of this package."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(_PACKAGE):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, DomainWarning, stacklevel=level)
