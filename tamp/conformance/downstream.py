"""Of what use a sampler's outputs are: the share that the streams that need them can go on with."""

from __future__ import annotations

from collections.abc import Sequence

from tamp.conformance.bench import Bench
from tamp.conformance.calls import Call, call
from tamp.conformance.pool import Pool
from tamp.language import Stream

TRIED = 12
"""So many inputs are tried of each stream downstream."""


def shares(bench: Bench, stream: Stream, calls: Sequence[Call], seed: int) -> dict[str, float]:
    """Stream that takes an output -> share of inputs with such outputs for which the domain's sampler finds something.

    Args:
        bench: the problem.
        stream: whose outputs they are.
        calls: what was drawn.
        seed: decides every random choice.
    """
    promised = {atom.predicate for atom in stream.certified}
    passed: dict[str, float] = {}
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
            found = [bool(_first(bench, later, values, n, seed).outputs) for n, values in enumerate(inputs)]
            passed[later.name] = sum(found) / len(found)
    return passed


def _first(bench: Bench, stream: Stream, values: tuple[object, ...], number: int, seed: int) -> Call:
    return call(bench.problem, stream, values, key=str(number), seed=seed, outputs=1)
