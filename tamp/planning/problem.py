"""What is asked and what is answered: Problem, StreamInfo, Solution."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

from tamp.errors import DomainError
from tamp.language import Domain, Formula, InitialState, StreamFile, parse_domain, parse_goal, parse_init, parse_streams
from tamp.planning.report import Report
from tamp.planning.signature import check_samplers


@dataclass(frozen=True, slots=True)
class StreamInfo:
    """What the planner may know of a stream beyond its text; everything is optional.

    Attributes:
        eager: call it for all inputs at once, before any search.
        p_success: how likely one call yields something, in (0, 1]; rarer streams are used more reluctantly.
        cost: how expensive a call is, in units of a cheap one; expensive streams are used more reluctantly.
        defer: bind its outputs after everything else in a plan; None defers exactly the streams with `:fluents`.
        fresh: whether its outputs are never equal to an object known before, as draws from a continuum are not; some
            problems can only then be proven infeasible while it goes on.
        bound: what a function is assumed to return before it was called, a lower bound.
    """

    eager: bool = False
    p_success: float = 1.0
    cost: float = 1.0
    defer: bool | None = None
    fresh: bool = False
    bound: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.p_success <= 1.0:
            raise DomainError(f"StreamInfo: p_success must lie in (0, 1], found {self.p_success!r}")
        for name in ("cost", "bound"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise DomainError(f"StreamInfo: {name} must be 0 or more and finite, found {getattr(self, name)!r}")


@dataclass(frozen=True)
class Problem:
    """A planning problem with streams, in PDDLStream's form.

    Attributes:
        domain: PDDL text or the file it lies in.
        streams: stream PDDL text or file; None for a problem without streams.
        samplers: stream name -> function. A stream's is a generator function that yields one output (a tuple where
            there are several; None for "nothing yet"); a test's or predicate's returns a bool, a function's a number.
        init: facts such as `("AtPose", obj, pose)` and function values `("=", ("Distance", a, b), 5.0)`.
        goal: nested tuples such as `("and", ("On", a, b), ("exists", ("?p",), ("AtPose", c, "?p")))`.
        scene: what samplers find as `context.scene`; the planner does not look into it.
        info: stream name -> StreamInfo.
        constants: the objects that constants of the domain stand for, where that is not their name.

    Raises:
        DomainError: where a text, a fact or the goal cannot be read.
        SamplerError: where a sampler is missing, unknown, or does not take its stream's inputs.
    """

    domain: str | Path
    streams: str | Path | None = None
    samplers: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    init: Iterable[Any] = ()
    goal: Any = None
    scene: Any = None
    info: Mapping[str, StreamInfo] = field(default_factory=dict)
    constants: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "init", tuple(self.init))
        for name in ("samplers", "info"):
            lowered = {key.lower(): value for key, value in getattr(self, name).items()}
            object.__setattr__(self, name, MappingProxyType(lowered))
        check_samplers(self.parsed_streams, self.samplers, self.info)
        _ = self.initial_state, self.goal_formula  # read now, so that mistakes show at construction

    @cached_property
    def parsed_domain(self) -> Domain:
        """The domain as data."""
        return parse_domain(self.domain, self.constants)

    @cached_property
    def parsed_streams(self) -> StreamFile:
        """The stream file as data."""
        return parse_streams(self.streams, self.parsed_domain)

    @cached_property
    def initial_state(self) -> InitialState:
        """The initial facts as data."""
        return parse_init(self.init, self.parsed_domain, self.parsed_streams)

    @cached_property
    def goal_formula(self) -> Formula:
        """The goal as data."""
        return parse_goal(self.goal, self.parsed_domain, self.parsed_streams)


@dataclass(frozen=True, slots=True)
class GroundAction:
    """An action with the values of its parameters."""

    name: str
    args: tuple[Any, ...]


@dataclass(frozen=True)
class Solution:
    """What a run of the planner found.

    Attributes:
        plan: the actions in order; None where no plan was found.
        cost: the plan's cost; infinite without a plan.
        status: "solved"; "infeasible" where that is proven: all streams are exhausted, or those that are not cannot
            bring the goal within reach by what they promise; "timeout"; "failed" where a limit other than time ended
            the search; "interrupted".
        certified: all facts that streams certified for the plan, as tuples with values.
        report: where the time went, what was tried and what failed.
        picture: graphviz text of the plan and the streams that feed it.
    """

    plan: tuple[GroundAction, ...] | None
    cost: float
    status: str
    certified: tuple[tuple[Any, ...], ...]
    report: Report
    picture: str = ""

    @property
    def solved(self) -> bool:
        """Whether there is a plan."""
        return self.plan is not None
