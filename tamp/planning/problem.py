"""What the planner is given and gives: the problem, its solution, and how samplers fit their streams."""

from __future__ import annotations

import inspect
import math
import numbers
import reprlib
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from tamp.errors import DomainError, DomainWarning, SamplerError, meant
from tamp.frozen import FrozenDict
from tamp.language import (
    PDDL,
    Domain,
    Formula,
    FunctionStream,
    InitialState,
    PredicateStream,
    Stream,
    StreamFile,
    parse_domain,
    parse_goal,
    parse_init,
    parse_streams,
)
from tamp.planning.report import Report
from tamp.planning.sampling.optimizers import with_components
from tamp.planning.wrappers import DEBUG, SHARED_DEBUG, Adapted, debug_samplers


def check_samplers(streams: StreamFile, samplers: Mapping[str, Callable[..., Any]], info: Mapping[str, Any]) -> None:
    """Check that each stream has a function that takes a context and the stream's inputs, and that all names are known.

    Raises:
        SamplerError: naming the stream, what was expected and what was found.
    """
    externals: dict[str, Stream | FunctionStream | PredicateStream] = {}
    externals.update({s.name: s for s in streams.streams})
    externals.update({f.name: f for f in streams.functions})
    externals.update({p.name: p for p in streams.predicates})
    for kind, names in (("sampler", samplers), ("info", info)):
        for name in names:
            if name not in externals:
                known = f"{meant(name, externals)}there are: {', '.join(externals)}"
                if isinstance(samplers.get(name), Adapted):
                    message = f"the stream map names {name!r}, which is no stream and is ignored"
                    warnings.warn(f"{message}; {known}", DomainWarning, stacklevel=4)
                    continue
                raise SamplerError(f"{kind} for unknown stream {name!r}; {known}")
    for name, known in info.items():
        if not isinstance(known, StreamInfo):
            raise SamplerError(f"info for stream {name!r}: expected a StreamInfo, found {reprlib.repr(known)}")
    for name, external in externals.items():
        if name not in samplers:
            raise SamplerError(f"stream {name!r} has no sampler; given are: {', '.join(samplers) or 'none'}")
        check_sampler(external, samplers[name])


def debug_map(name: str, streams: StreamFile) -> Mapping[str, Callable[..., Any]]:
    """The samplers that a name stands for.

    Raises:
        SamplerError: for another name than those of the debug maps.
    """
    if name not in (DEBUG, SHARED_DEBUG):
        raise SamplerError(f"samplers: expected a mapping, {DEBUG!r} or {SHARED_DEBUG!r}, found {name!r}")
    return debug_samplers(streams, shared=name == SHARED_DEBUG)


def check_sampler(external: Stream | FunctionStream | PredicateStream, sampler: Callable[..., Any]) -> None:
    """Check that a function takes a context and a stream's inputs.

    Raises:
        SamplerError: says what was expected and what was found.
    """
    inputs = tuple(str(variable)[1:] for variable in external.inputs)
    expected = f"sampler of stream {external.name!r}: expected a function of ({', '.join(('context', *inputs))})"
    if not callable(sampler):
        raise SamplerError(f"{expected}, found {reprlib.repr(sampler)}")
    try:
        signature = inspect.signature(sampler)
    except (TypeError, ValueError):
        return  # functions written in C do not all tell what they take
    try:
        signature.bind(*range(len(inputs) + 1))
    except TypeError as error:
        found = f"{getattr(sampler, '__name__', repr(sampler))}{signature}"
        if inspect.isclass(sampler):  # its instances may well be what is expected
            found = f"the class {sampler.__qualname__}, whose instances are made by {found}; give an instance"
        raise SamplerError(f"{expected}, found {found}: {error}") from None


@dataclass(frozen=True, slots=True)
class StreamInfo:
    """What the planner may know of a stream beyond its text; everything is optional.

    Attributes:
        eager: call it for all inputs at once, before any search.
        p_success: how likely one call yields something, in [0, 1]; rarer streams are used more reluctantly. 0 counts as
            one in a thousand, None as 1.
        cost: how expensive a call is, in units of a cheap one; expensive streams are used more reluctantly.
        defer: bind its outputs after everything else in a plan; None defers exactly the streams with `:fluents`.
        fresh: whether its outputs are never equal to an object known before, as draws from a continuum are not; some
            problems can only then be proven infeasible while it goes on.
        complete: whether nothing more exists once a sampler has ended, as where it lists a finite set. One that draws
            from a continuum, or tries so often, ends without proof: no problem is called infeasible for it.
        bound: what a function is assumed to return before it was called, a lower bound.
        overhead: the cost by its name in PDDLStream; None for what `cost` says.
        opt_gen_fn, use_unique, negate, effort, effort_fn, estimate, simultaneous, verbose, defer_fn: accepted for
            PDDLStream's sake, and without effect, as a warning says where it matters: a placeholder needs no value
            here and belongs to one instance, every test may be planned with negated, efforts are learnt, and a plan is
            bound as a whole, where PDDLStream puts off what comes after one of its `replan_actions`.
    """

    eager: bool = False
    p_success: float = 1.0
    cost: float = 1.0
    defer: bool | None = None
    fresh: bool = False
    complete: bool = True
    bound: float = 0.0
    opt_gen_fn: Any = None
    negate: bool = False
    overhead: float | None = None
    use_unique: bool = False
    defer_fn: Any = None
    effort: float | None = None
    effort_fn: Any = None
    estimate: bool = False
    simultaneous: bool = False
    verbose: bool = True

    def __post_init__(self) -> None:
        if self.overhead is not None:
            object.__setattr__(self, "cost", self.overhead)
        without = [name for name in ("opt_gen_fn", "effort", "effort_fn") if getattr(self, name) is not None]
        for name in ("p_success", "cost"):
            if callable(getattr(self, name)):  # of the inputs
                without.append(f"{name} as a function")
                object.__setattr__(self, name, 1.0)
        if self.p_success is None:
            object.__setattr__(self, "p_success", 1.0)
        for name in ("p_success", "cost", "bound"):
            if not isinstance(getattr(self, name), numbers.Real):
                raise DomainError(f"StreamInfo: {name} must be a number, found {getattr(self, name)!r}")
        if without:
            names = ", ".join(without)
            message = f"StreamInfo: without effect here: {names}; numbers for p_success and overhead are looked at"
            warnings.warn(message, DomainWarning, stacklevel=3)
        if not 0.0 <= self.p_success <= 1.0:
            raise DomainError(f"StreamInfo: p_success must lie in [0, 1], found {self.p_success!r}")
        for name in ("cost", "bound"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise DomainError(f"StreamInfo: {name} must be 0 or more and finite, found {getattr(self, name)!r}")


@dataclass(frozen=True)
class Problem:
    """A planning problem with streams, in PDDLStream's form.

    Attributes:
        domain: PDDL text or the file it lies in, or several of either, whose sections are read as one domain;
            or a domain that was read already.
        streams: stream PDDL text or file, or several; None for a problem without streams.
        samplers: stream name -> function. A stream's is a generator function that yields one output (a tuple where
            there are several; None for "nothing yet"); a test's or predicate's returns a bool, a function's a number.
            An optimizer's name -> its procedure, see `tamp.planning.sampling.optimizers`.
            "debug" stands for samplers that give values with nothing but names, to try a domain without any;
            "shared-debug" for such values that do not depend on a stream's inputs.
        init: facts such as `("AtPose", obj, pose)` and function values `("=", ("Distance", a, b), 5.0)`.
        goal: nested tuples such as `("and", ("On", a, b), ("exists", ("?p",), ("AtPose", c, "?p")))`.
        scene: what samplers find as `context.scene`; the planner does not look into it.
        info: stream name -> StreamInfo.
        constants: the objects that constants of the domain stand for, where that is not their name.
        soft_goals: further goals, each with the utility of reaching it, in units of the plan's cost; only the strategy
            "net-benefit" plans for them.

    Raises:
        DomainError: where a text, a fact or the goal cannot be read.
        SamplerError: where a sampler is missing, unknown, or does not take its stream's inputs.
    """

    domain: PDDL | Domain
    streams: PDDL | None = None
    samplers: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    init: Iterable[Any] = ()
    goal: Any = None
    scene: Any = None
    info: Mapping[str, StreamInfo] = field(default_factory=dict)
    constants: Mapping[str, Any] = field(default_factory=dict)
    soft_goals: tuple[tuple[Any, float], ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "soft_goals", tuple(self.soft_goals))
        if isinstance(self.init, Iterable) and not isinstance(self.init, str):
            object.__setattr__(self, "init", tuple(self.init))
        if isinstance(self.samplers, str):
            object.__setattr__(self, "samplers", debug_map(self.samplers, self.parsed_streams))
        for name in ("samplers", "info"):
            if not isinstance(getattr(self, name), Mapping):
                found = reprlib.repr(getattr(self, name))
                raise SamplerError(f"{name}: expected a mapping from streams' names, found {found}")
            lowered = {key.lower(): value for key, value in getattr(self, name).items()}
            lowered = with_components(self.parsed_streams, lowered) if name == "samplers" else lowered
            object.__setattr__(self, name, FrozenDict(lowered))
        check_samplers(self.parsed_streams, self.samplers, self.info)
        _ = (
            self.initial_state,
            self.goal_formula,
            self.soft_goal_formulas,
        )  # read now, so that mistakes show at construction

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

    @cached_property
    def soft_goal_formulas(self) -> tuple[tuple[Formula, float], ...]:
        """The soft goals as data, with their utilities."""
        return tuple(_soft_goal(each, self.parsed_domain, self.parsed_streams) for each in self.soft_goals)


def _soft_goal(given: Any, domain: Domain, streams: StreamFile) -> tuple[Formula, float]:
    match given:
        case (goal, numbers.Real() as utility) if 0 < float(utility) < math.inf:
            return parse_goal(goal, domain, streams), float(utility)
    raise DomainError(
        f"soft_goals: expected pairs such as (('On', a, b), 5.0) of a goal and its utility above 0, found {given!r}"
    )


@dataclass(frozen=True, slots=True)
class GroundAction:
    """An action with the values of its parameters; `name, args = action` takes it apart."""

    name: str
    args: tuple[Any, ...]

    def __iter__(self) -> Iterator[Any]:
        """Name and arguments."""
        return iter((self.name, self.args))

    def __len__(self) -> int:
        """How many parts it is taken apart into."""
        return 2

    def __getitem__(self, index: Any) -> Any:
        """One of these parts, or some."""
        return (self.name, self.args)[index]


class Certificate(tuple[tuple[Any, ...], ...]):
    """Facts that streams certified, by the names that PDDLStream's scripts have for them as well."""

    __slots__ = ()

    @property
    def all_facts(self) -> list[tuple[Any, ...]]:
        """All that hold at the start or were certified."""
        return list(self)

    preimage_facts = all_facts


@dataclass(frozen=True)
class Solution:
    """What a run of the planner found; `plan, cost, certified = solution` takes it apart.

    Attributes:
        plan: the actions in order; None where no plan was found.
        cost: the plan's cost; infinite without a plan.
        status: "solved"; "infeasible" where that is proven: all streams are exhausted, or those that are not cannot
            bring the goal within reach by what they promise; "timeout"; "failed" where a limit other than time ended
            the search; "interrupted".
        certified: all facts that streams certified for the plan, as tuples with values.
        report: where the time went, what was tried and what failed.
        picture: graphviz text of the plan and the streams that feed it.
        forgone: the soft goals that the plan does not reach.
    """

    plan: tuple[GroundAction, ...] | None
    cost: float
    status: str
    certified: tuple[tuple[Any, ...], ...]
    report: Report
    picture: str = ""
    forgone: tuple[Any, ...] = ()

    @property
    def solved(self) -> bool:
        """Whether there is a plan."""
        return self.plan is not None

    def __iter__(self) -> Iterator[Any]:
        """Plan, cost and certified facts, as PDDLStream's solvers return them."""
        return iter((self.plan, self.cost, self.certificate))

    def __len__(self) -> int:
        """How many parts it is taken apart into."""
        return 3

    def __getitem__(self, index: Any) -> Any:
        """One of these parts, or some."""
        return tuple(self)[index]

    @property
    def certificate(self) -> Certificate:
        """The certified facts, by PDDLStream's name for them."""
        return Certificate(self.certified)

    @property
    def facts(self) -> Certificate:
        """The same, by another name that they have there."""
        return self.certificate
