"""Streams with `:fluents` in axioms: what one gives holds in one state, so that axioms ask whether it gives anything.

A rule such as "reachable is what some motion leads to" wants no motion, only that there is one in the state at hand. A
test with the stream's own sampler answers that, as it answers for tests with `:fluents` of the file.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from tamp.planning.model.external import External
from tamp.planning.model.normal_form import AxiomSchema, put
from tamp.planning.model.objects import Pattern

ANY_MARK = "@any-"
"""Prefix of the test that asks a stream for any output, and of what it certifies of the stream's inputs."""


def ask_for_any(
    externals: Mapping[str, External],
    axioms: tuple[AxiomSchema, ...],
    elsewhere: Collection[str],
    given: Collection[str],
) -> tuple[dict[str, External], tuple[AxiomSchema, ...]]:
    """The streams and axioms with such tests, where an axiom uses what a stream gives for nothing else.

    A stream of which nothing but axioms asks gives no values any more. What else may bring a fact keeps the axiom as it
    is beside the other: the problem, other streams, or a wild one where the stream itself gives no more.

    Args:
        externals: the streams by name.
        axioms: of the domain.
        elsewhere: predicates that something other than axioms asks for.
        given: those of the problem's facts.
    """
    momentary = [e for e in externals.values() if e.fluents and e.outputs and not e.optimizer]
    made: dict[str, External] = dict(externals)
    rewritten: list[AxiomSchema] = []
    for axiom in axioms:
        asking, asked = axiom, list[External]()
        while (found := _first(asking, momentary)) is not None:
            stream, asking = found
            asked.append(stream)
        rewritten += [asking] if asked else []
        if not asked or any(_otherwise(stream, externals, elsewhere, given) for stream in asked):
            rewritten.append(axiom)
        for stream in asked:
            if not _is_used(stream, elsewhere):
                made.pop(stream.name, None)
            made[ANY_MARK + stream.name] = _test(stream)
    return made, tuple(rewritten)


def _is_used(stream: External, elsewhere: Collection[str]) -> bool:
    return any(p[0] in elsewhere for p in stream.certified)


def _otherwise(
    stream: External, externals: Mapping[str, External], elsewhere: Collection[str], given: Collection[str]
) -> bool:
    """Whether what a stream certifies may come from elsewhere too; where it gives no more itself, always."""
    names = {p[0] for p in stream.certified}
    others = {p[0] for e in externals.values() if e is not stream for p in e.certified}
    return not _is_used(stream, elsewhere) or not names.isdisjoint(others | set(given))


def _test(stream: External) -> External:
    name = ANY_MARK + stream.name
    info = replace(stream.info, eager=False)
    return replace(stream, name=name, outputs=(), certified=((name, *stream.inputs),), info=info, asks=stream)


def _first(axiom: AxiomSchema, streams: list[External]) -> tuple[External, AxiomSchema] | None:
    """The first stream whose outputs an axiom has no other use for, and the axiom that asks for any."""
    for literal in axiom.condition.positive:
        for stream in streams:
            asking = _asking(axiom, literal, stream)
            if asking is not None:
                return stream, asking
    return None


def _asking(axiom: AxiomSchema, literal: Pattern, stream: External) -> AxiomSchema | None:
    """An axiom that asks for any output of a stream in place of what a literal says of one, where it may."""
    for certified in (p for p in stream.certified if p[0] == literal[0]):
        terms = {str(t): term for t, term in zip(certified[1:], literal[1:], strict=True)}
        outputs = {term for name in stream.outputs if isinstance(term := terms.get(name), str)}
        if len(terms) < len(literal) - 1 or len(outputs) < len(stream.outputs) or not terms.keys() >= {*stream.inputs}:
            continue
        said = {put(p, terms) for p in stream.certified if not outputs.isdisjoint(put(p, terms))}
        said |= {("object", term) for term in outputs}
        rest = replace(axiom.condition, positive=tuple(p for p in axiom.condition.positive if p not in said))
        test = (ANY_MARK + stream.name, *(terms[name] for name in stream.inputs))
        if outputs.isdisjoint(
            {*axiom.head[1:], *test[1:], *rest.variables(), *(t for pair in rest.equal for t in pair)}
        ):
            return AxiomSchema(axiom.head, replace(rest, positive=(*rest.positive, test)))
    return None
