"""An optimizer's procedure: asked about one of its streams alone, or about all that a plan wants of it at once.

A procedure is called with names of the values to find ("?x"), facts that shall hold of them, terms to make small and
what is known of the values, and gives assignments: tuples of values, one for each name. PDDLStream's are functions of
`(outputs, facts, hint={})`, in one of its wrappers; others take a context first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from tamp.errors import SamplerError
from tamp.language import Atom, Stream, StreamFile, Variable
from tamp.planning.context import Context
from tamp.planning.wrappers import Adapted, UnfitOutputsError

ALONE = "the optimizer gave nothing more for these inputs alone"


def ask(
    procedure: Callable[..., Any], context: Context, outputs: tuple[str, ...], facts: tuple[tuple[Any, ...], ...]
) -> Iterable[Any]:
    """What a procedure gives: an iterable of assignments, each the only value or a tuple of several.

    Raises:
        UnfitOutputsError: where it gives something else, such as one `OptimizerOutput`.
    """
    if isinstance(procedure, Adapted):
        given, mend = procedure.sampler(outputs, facts, hint={}), "wrap the optimizer's procedure in from_list_fn"
    else:
        given, mend = procedure(context, outputs, facts, {}), "yield each assignment"
    if not isinstance(given, Iterable):
        raise UnfitOutputsError(f"expected several assignments, found one {type(given).__name__}; {mend}")
    return given


@dataclass(frozen=True)
class Component:
    """The sampler of one stream of an optimizer, which asks the procedure about that stream alone.

    That nothing more comes for it alone proves nothing: together with others there may be more.
    """

    stream: Stream
    procedure: Callable[..., Any]

    def __call__(self, context: Context, *inputs: Any) -> Iterator[Any]:
        """Assignments to the stream's outputs; for a constraint, one without values where it holds."""
        values = dict(zip(self.stream.inputs, inputs, strict=True))

        def written(atom: Atom) -> tuple[Any, ...]:
            terms = ((values.get(t, str(t)) if isinstance(t, Variable) else t.value) for t in atom.args)
            return (atom.predicate, *terms)

        facts = tuple(map(written, self.stream.certified))
        yield from ask(self.procedure, context, tuple(map(str, self.stream.outputs)), facts)
        if self.stream.outputs:
            context.fail(ALONE, proven=False)


def with_components(streams: StreamFile, samplers: Mapping[str, Callable[..., Any]]) -> dict[str, Callable[..., Any]]:
    """Samplers in which each stream of an optimizer has its own, in place of the optimizer's procedure.

    Raises:
        SamplerError: where an optimizer has no procedure, and its streams have no samplers of their own.
    """
    made = dict(samplers)
    for stream in streams.streams:
        if stream.optimizer and stream.name not in made:
            if stream.optimizer not in samplers:
                given = ", ".join(samplers) or "none"
                raise SamplerError(f"optimizer {stream.optimizer!r} has no procedure; given are: {given}")
            made[stream.name] = Component(stream, samplers[stream.optimizer])
    for name, _ in streams.objectives:
        made.pop(name, None)
    return made
