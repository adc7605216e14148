"""Of what use a sampler's outputs are: the share that the streams that need them can go on with."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from tamp.conformance.sampler.bench import Bench
from tamp.conformance.sampler.calls import Call, call
from tamp.conformance.sampler.pool import Pool
from tamp.language import Stream

TRIED = 12
"""So many inputs are tried of each stream downstream."""


@dataclass(frozen=True)
class Passed:
    """How many outputs a stream downstream can go on with, and what it said of the others, commonest first."""

    share: float
    reasons: tuple[str, ...]


def shares(bench: Bench, stream: Stream, calls: Sequence[Call], seed: int) -> dict[str, Passed]:
    """Stream that takes an output -> share of inputs with such outputs for which the domain's sampler finds something.

    Args:
        bench: the problem.
        stream: whose outputs they are.
        calls: what was drawn.
        seed: decides every random choice.
    """
    promised = {atom.predicate for atom in stream.certified}
    passed: dict[str, Passed] = {}
    for later in bench.problem.parsed_streams.streams:
        if later.name == stream.name or stream.is_test or not promised & {atom.predicate for atom in later.domain}:
            continue
        others = Pool(bench.problem, seed)
        others.provide_but(later, stream)
        for made in calls:
            others.take(stream, made.inputs, made.outputs)
        fresh = {id(value) for made in calls for output in made.outputs for value in output}
        inputs = [v for v in others.inputs(later, 20 * TRIED) if any(id(value) in fresh for value in v)][:TRIED]
        if inputs:
            made_of = [_first(bench, later, values, n, seed) for n, values in enumerate(inputs)]
            failed = [made for made in made_of if not made.outputs]
            said = Counter(reason for made in failed for reason in {*made.reasons, made.error} - {""})
            ordered = sorted(said, key=lambda reason: (-said[reason], reason))
            passed[later.name] = Passed(1 - len(failed) / len(made_of), tuple(ordered))
    return passed


def _first(bench: Bench, stream: Stream, values: tuple[object, ...], number: int, seed: int) -> Call:
    return call(bench.problem, stream, values, key=str(number), seed=seed, outputs=1)
