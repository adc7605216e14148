"""Facts to call a sampler with: those of a problem, and those that its streams certify when they are called in turn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from tamp.conformance.sampler.calls import Call, call
from tamp.language import Atom, Constant, Stream, Variable
from tamp.planning import Problem

OUTPUTS = 3
"""So many outputs are drawn from one call upstream."""

CALLS = 6
"""So many calls are made of one stream upstream."""

Values = tuple[Any, ...]
Binding = dict[Variable, Constant]


class Pool:
    """Facts of a problem, grown by its own samplers.

    Args:
        problem: whose facts and samplers to use.
        seed: decides every random choice.
    """

    def __init__(self, problem: Problem, seed: int) -> None:
        self._problem = problem
        self._seed = seed
        self._facts: dict[str, list[tuple[Constant, ...]]] = {}
        for fact in problem.init:
            self.add(fact)

    def add(self, fact: Sequence[Any]) -> None:
        """Take a fact in, once."""
        known = self._facts.setdefault(str(fact[0]).lower(), [])
        args = tuple(map(Constant, fact[1:]))
        if args not in known:
            known.append(args)

    def provide(self, stream: Stream) -> None:
        """Call whatever streams certify the facts that a stream's inputs must satisfy."""
        self._provide(stream, {stream.name})

    def provide_but(self, stream: Stream, absent: Stream) -> None:
        """The same without calling one of them."""
        self._provide(stream, {stream.name, absent.name})

    def _provide(self, stream: Stream, visited: set[str]) -> None:
        wanted = {atom.predicate for atom in stream.domain}
        for source in self._problem.parsed_streams.streams:
            if source.name in visited or not wanted & {atom.predicate for atom in source.certified}:
                continue
            visited.add(source.name)
            self._provide(source, visited)
            for number, values in enumerate(self.inputs(source, CALLS)):
                self.take(source, values, self.draw(source, values, number).outputs)

    def draw(self, stream: Stream, values: Values, number: int) -> Call:
        """Call the problem's own sampler of a stream."""
        return call(self._problem, stream, values, key=str(number), seed=self._seed, outputs=OUTPUTS)

    def take(self, stream: Stream, values: Values, outputs: Sequence[Values]) -> None:
        """Take in what a stream certifies of inputs and outputs."""
        for output in outputs:
            named = dict(zip((*stream.inputs, *stream.outputs), (*values, *output), strict=True))
            for atom in stream.certified:
                self.add((atom.predicate, *(named[t] if isinstance(t, Variable) else t.value for t in atom.args)))

    def inputs(self, stream: Stream, count: int) -> list[Values]:
        """Up to `count` different inputs that satisfy a stream's domain, drawn at random from all that there are.

        A value beside itself tells nothing, as a motion to where the arm is already, or an object that stands beside
        itself: inputs that have one twice are taken only where there are no others.
        """
        found = dict.fromkeys(
            tuple(binding[variable] for variable in stream.inputs) for binding in self._matches(stream.domain, {})
        )
        every = [values for values in found if len(values) == len(set(values))] or list(found)
        order = np.random.default_rng(self._seed).permutation(len(every))[:count]
        return [tuple(constant.value for constant in every[i]) for i in order]

    def _matches(self, pattern: Sequence[Atom], binding: Binding) -> Iterator[Binding]:
        if not pattern:
            yield binding
            return
        first, *rest = pattern
        for args in self._facts.get(first.predicate, ()):
            extended = _unified(first, args, binding)
            if extended is not None:
                yield from self._matches(rest, extended)


def _unified(atom: Atom, args: Sequence[Constant], binding: Binding) -> Binding | None:
    extended = dict(binding)
    for term, value in zip(atom.args, args, strict=True):
        meant = extended.setdefault(term, value) if isinstance(term, Variable) else term
        if meant != value:
            return None
    return extended
