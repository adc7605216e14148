"""PDDLStream's wrappers of samplers, and its constructors of formulas and outputs.

PDDLStream's samplers take no context and give tuples of outputs, also where there is only one; its `stream_map` wraps
each by what kind of function it is, and holds functions and predicates bare. The wrappers here have the same names:
`Problem(..., samplers=from_stream_map(stream_map))` takes such a map as it is. Where a stream has `:fluents`, its
function gets those that hold as the keyword argument `fluents`. Where a generator yields a `WildOutput` in place of a
list, anything with lists `values` and `facts`, the facts are certified with the outputs. Formulas are nested tuples, as
they are there: the constructors put names to them.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial, wraps
from itertools import count
from typing import Any, overload

from tamp import clock
from tamp.errors import SamplerError
from tamp.language import FunctionStream, StreamFile
from tamp.planning.context import Certified, Context

Outputs = tuple[Any, ...] | list[Any]


@dataclass(frozen=True)
class Adapted:
    """A sampler that was wrapped: called as this planner does, with a context first.

    Attributes:
        gives_up: why its end is no proof that nothing more exists; empty where it is one.
        function: what was wrapped, which messages name; None where nobody wrote one.
    """

    sampler: Callable[..., Any]
    gives_up: str = ""
    function: Callable[..., Any] | None = None

    def __call__(self, context: Context, *inputs: Any) -> Any:
        """What the stream gets for its inputs."""
        made = self.sampler(*inputs, **({"fluents": context.fluents} if context.sees_fluents else {}))
        return self._until_given_up(context, made) if self.gives_up else made

    def _until_given_up(self, context: Context, made: Iterable[Any]) -> Iterator[Any]:
        yield from made
        context.fail(self.gives_up, proven=False)


class UnfitOutputsError(SamplerError):
    """What a wrapped function gave is not what its wrapper takes; whoever called it knows for which stream."""


class SeveralOutputs(tuple[Any, ...]):
    """The outputs of one draw where there is not exactly one: never the single value that a stream waits for."""


def outputs_of(output: Any, count: int) -> tuple[Any, ...] | None:
    """The values of one draw, where a stream waits for so many; None where there are not as many."""
    values = (output,) if count == 1 and not isinstance(output, SeveralOutputs) else output
    return tuple(values) if isinstance(values, tuple | list) and len(values) == count else None


def shown(output: Any) -> str:
    """What a sampler gave, in a message."""
    return reprlib.repr(tuple(output) if isinstance(output, SeveralOutputs) else output)


@dataclass(frozen=True)
class WildOutput:
    """What a generator yields in place of a list of outputs, to certify more than its stream promises."""

    values: Iterable[Outputs] = ()
    facts: Iterable[tuple[Any, ...]] = ()


@dataclass(frozen=True)
class OptimizerOutput:
    """What an optimizer's procedure gives: assignments, tuples of values in the order of the names that it was given.

    Attributes:
        facts: what is certified besides.
        infeasible: without effect here: sets of facts that cannot hold together.
    """

    assignments: Iterable[Outputs] = ()
    facts: Iterable[tuple[Any, ...]] = ()
    infeasible: Iterable[Any] = ()

    def __bool__(self) -> bool:
        """Whether there is an assignment."""
        return bool(self.assignments)


@dataclass(frozen=True)
class DebugValue:
    """A value that stands for what a sampler would give. `inputs` are empty where all inputs share it."""

    stream: str
    inputs: tuple[Any, ...]
    output: str
    number: int

    @property
    def input_values(self) -> tuple[Any, ...]:
        """The inputs, by their name in PDDLStream."""
        return self.inputs

    @property
    def output_parameter(self) -> str:
        """The output as the stream file names it, such as "?q"."""
        return f"?{self.output}"

    def __str__(self) -> str:
        return f"{self.output}{self.number}"


DEBUG, SHARED_DEBUG = "debug", "shared-debug"
"""Names in place of a stream map: plan without samplers, with values of each instance's own or of each stream's."""

DEBUG_VALUES = 4
"""How many values a stream without inputs gives when it is planned without samplers; others give one, as there."""


def debug_samplers(streams: StreamFile, shared: bool = False) -> dict[str, Adapted]:
    """Samplers for every stream of a file: values that only have names, tests that hold, functions that return 1."""

    def generate(name: str, outputs: tuple[str, ...]) -> Adapted:
        def values(*inputs: Any, **fluents: Any) -> Iterator[Outputs]:
            own = () if shared else inputs
            for number in range(1 if inputs else DEBUG_VALUES):
                yield tuple(DebugValue(name, own, output, number) for output in outputs)

        return from_gen_fn(values)

    made = {s.name: generate(s.name, tuple(v.name[1:] for v in s.outputs)) for s in streams.streams if s.outputs}
    tests = [s.name for s in streams.streams if not s.outputs] + [p.name for p in streams.predicates]
    made |= {name: from_test(lambda *inputs, **fluents: True) for name in tests}
    functions: tuple[FunctionStream, ...] = streams.functions
    return made | {f.name: Adapted(lambda *inputs: 1.0) for f in functions}


@overload
def from_stream_map(stream_map: Mapping[str, Callable[..., Any]]) -> dict[str, Adapted]: ...


@overload
def from_stream_map(stream_map: str) -> Any: ...


def from_stream_map(stream_map: Mapping[str, Callable[..., Any]] | str) -> Any:
    """The samplers of a `stream_map`: those that are wrapped, and bare ones.

    A bare one is a function of a `:function` or `:predicate`, or a generator function that yields lists of tuples.
    "debug" and "shared-debug" stay as they are: `Problem` takes them in place of samplers.
    """
    if isinstance(stream_map, str):
        return stream_map
    return {name: made if isinstance(made, Adapted) else _bare(made) for name, made in stream_map.items()}


def from_list_gen_fn(generate: Callable[..., Iterable[Any]]) -> Adapted:
    """A generator function that yields a list of tuples, or a wild output, at a time; an empty one for "not yet"."""
    return Adapted(lambda *inputs, **fluents: _one_by_one(_all(generate(*inputs, **fluents))), function=generate)


def from_gen_fn(generate: Callable[..., Iterable[Outputs | None]]) -> Adapted:
    """A generator function that yields a tuple of outputs, or a wild output, at a time; None for "nothing yet"."""
    made = from_list_gen_fn(lambda *inputs, **fluents: map(_listed, _all(generate(*inputs, **fluents))))
    return replace(made, function=generate)


def from_list_fn(compute: Callable[..., Iterable[Outputs]]) -> Adapted:
    """A function that returns a list of tuples: all that there are."""
    made = from_list_gen_fn(lambda *inputs, **fluents: iter([compute(*inputs, **fluents)]))
    return replace(made, function=compute)


def from_fn(compute: Callable[..., Outputs | None]) -> Adapted:
    """A function that returns a tuple of outputs, or a wild output; None where there are none."""
    made = from_list_fn(lambda *inputs, **fluents: _listed(compute(*inputs, **fluents)))
    return replace(made, function=compute)


def from_sampler(sample: Callable[..., Outputs | None], max_attempts: float = math.inf) -> Adapted:
    """A function that returns a new tuple of outputs, or None, each of the `max_attempts` times that it is called."""

    def generate(*inputs: Any, **fluents: Any) -> Iterator[Outputs | None]:
        attempts = count()
        while next(attempts) < max_attempts:
            yield sample(*inputs, **fluents)

    gives_up = "" if max_attempts == math.inf else f"it was asked {max_attempts:g} times"
    return replace(from_gen_fn(generate), gives_up=gives_up, function=sample)


def from_constant(constant: Outputs) -> Adapted:
    """The same tuple of outputs for all inputs."""
    return from_fn(lambda *inputs, **fluents: constant)


def from_gen(generator: Iterable[Outputs | None]) -> Adapted:
    """Outputs that exist already, one at a time: for a stream without inputs, which is asked for them once."""
    return from_gen_fn(lambda *inputs, **fluents: generator)


def empty_gen() -> Adapted:
    """No outputs at all."""
    return from_list_gen_fn(lambda *inputs, **fluents: iter(()))


def accelerate_list_gen_fn(
    generate: Callable[..., Iterable[Any]], num_elements: int = 1, max_attempts: int = 1, max_time: float = math.inf
) -> Callable[..., Any]:
    """A generator function that yields at a time what another yields in up to `max_attempts` lists.

    A list has ended where it has `num_elements`, or `max_time` [s] has passed. What is wrapped already gives its
    outputs one by one, whatever their number: "nothing yet" is what it says less often.
    """
    until = partial(_until, most=num_elements, attempts=max_attempts, seconds=max_time)
    if isinstance(generate, Adapted):
        singly = generate.sampler

        def sampler(*inputs: Any, **fluents: Any) -> Any:
            made = singly(*inputs, **fluents)
            if not isinstance(made, Iterator):  # a test's answer
                return made
            return (x for several in until([] if x is None else [x] for x in made) for x in several or [None])

        return replace(generate, sampler=sampler)

    def accelerated(*inputs: Any, **fluents: Any) -> Iterator[list[Outputs]]:
        yield from until(generate(*inputs, **fluents))

    return accelerated


def _until(made: Iterable[Any], most: int, attempts: int, seconds: float) -> Iterator[list[Any]]:
    """Lists, several put together as one."""
    lists = iter(made)
    while True:
        until, elements, more = clock.now() + seconds, list[Any](), True
        for _ in range(attempts):
            found = next(lists, None)
            more = found is not None
            elements += found or ()
            if not more or len(elements) >= most or clock.now() >= until:
                break
        yield elements
        if not more:
            return


def from_test(test: Callable[..., Any]) -> Adapted:
    """A function that says yes or no, for a stream without outputs."""
    return Adapted(lambda *inputs, **fluents: bool(test(*inputs, **fluents)), function=test)


def fn_from_constant(constant: Any) -> Callable[..., Any]:
    """A function that returns the same for all inputs."""
    return lambda *inputs, **fluents: constant


def negate_test(test: Callable[..., Any]) -> Callable[..., bool]:
    """The test that says no where another says yes."""

    @wraps(test)
    def negated(*inputs: Any, **fluents: Any) -> bool:
        return not test(*inputs, **fluents)

    return negated


universe_test = fn_from_constant(True)
empty_test = fn_from_constant(False)


def outputs_from_boolean(holds: bool) -> Outputs | None:
    """What a generator yields in place of a test's answer."""
    return () if holds else None


def _bare(function: Callable[..., Any]) -> Adapted:
    def sampler(*inputs: Any, **fluents: Any) -> Any:
        made = function(*inputs, **fluents)
        return _one_by_one(made) if isinstance(made, Iterator) else made

    return Adapted(sampler, function=function)


def _one_by_one(generated: Iterable[Any]) -> Iterator[Any]:
    """The outputs of lists and wild outputs, and None for each that is empty."""
    for several in generated:
        if hasattr(several, "facts"):
            facts = tuple(map(tuple, several.facts))
            optimized = hasattr(several, "assignments")
            made = [*map(_plain, several.assignments if optimized else several.values)] or [None]
            yield from made if optimized and not facts else (Certified(outputs, facts) for outputs in made)
        else:
            yield from [*map(_plain, _all(several, "a list of tuples of outputs such as [(x,)]"))] or [None]


def _all(given: Any, expected: str = "a generator function") -> Iterable[Any]:
    """What was given, which must be something to iterate over."""
    if not isinstance(given, Iterable):
        raise UnfitOutputsError(f"expected {expected}, as PDDLStream's samplers give, found {reprlib.repr(given)}")
    return given


def _listed(outputs: Any) -> Any:
    """One tuple of outputs as a list of them; a wild output is one already."""
    if hasattr(outputs, "facts"):
        return outputs
    return [] if outputs is None else [outputs]


def _plain(outputs: Outputs) -> Any:
    """Outputs as streams yield them here: one by itself, several as a tuple."""
    if not isinstance(outputs, tuple | list):
        raise UnfitOutputsError(
            f"expected a tuple of outputs such as (x,), as PDDLStream's samplers give, found {reprlib.repr(outputs)}"
        )
    return outputs[0] if len(outputs) == 1 else SeveralOutputs(outputs)


Formula = tuple[Any, ...]

TOTAL_COST = "total-cost"


def And(*parts: Formula) -> Formula:
    """All parts hold."""
    return ("and", *parts)


def Or(*parts: Formula) -> Formula:
    """At least one part holds."""
    return ("or", *parts)


def Not(part: Formula) -> Formula:
    """The part does not hold."""
    return ("not", part)


def Imply(condition: Formula, part: Formula) -> Formula:
    """The part holds where the condition does."""
    return ("imply", condition, part)


def Equal(left: Any, right: Any) -> Formula:
    """Two terms are the same; in an initial state, a function has a value."""
    return ("=", left, right)


def Exists(variables: Iterable[str], part: Formula) -> Formula:
    """The part holds for some objects."""
    return ("exists", tuple(variables), part)


def ForAll(variables: Iterable[str], part: Formula) -> Formula:
    """The part holds for all objects."""
    return ("forall", tuple(variables), part)


def Type(name: Any, kind: str) -> tuple[Any, str, str]:
    """A name and its type, as in a list of parameters."""
    return (name, "-", kind)


def Fact(predicate: str, args: Iterable[Any]) -> Formula:
    """A predicate of arguments."""
    return (predicate, *args)


def Output(*values: Any) -> tuple[Any, ...]:
    """The outputs of one draw."""
    return values
