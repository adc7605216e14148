"""Which calls tell most: those on which a wrong sampler and a right one part."""

from __future__ import annotations

from collections.abc import Hashable
from itertools import chain, zip_longest

import numpy as np

from tamp.conformance.sampler.arm_scene import arm_checker
from tamp.conformance.sampler.calls import call, fluents_of
from tamp.conformance.sampler.pool import Pool, Values
from tamp.language import Stream
from tamp.planning import Problem
from tamp.streams.collisions import ARM_MARGIN
from tamp.streams.values import Configuration
from tamp.streams.workspace import TABLE

ANY = "any"

CANDIDATES = 8
"""So many inputs are looked at for each call."""


def telling(problem: Problem, stream: Stream, pool: Pool, count: int) -> tuple[list[Values], bool]:
    """Up to `count` inputs, as many of each kind as can be, and whether there are all kinds of them.

    Tests are asked where the domain's own says yes and where it says no, motions where the straight line is free and
    where something is in its way, placements on a part of the table too; all other inputs are of one kind.
    """
    kinds: dict[Hashable, list[Values]] = {}
    for values in pool.inputs(stream, CANDIDATES * count):
        kinds.setdefault(_kind(problem, stream, values), []).append(values)
    hopeless = kinds.pop(None, [])
    every = [values for values in chain(*zip_longest(*kinds.values())) if values is not None]
    enough = len(kinds) > 1 or ANY in kinds
    return (every or hopeless)[:count], enough


def _kind(problem: Problem, stream: Stream, values: Values) -> Hashable:
    """What tells inputs of a stream apart; None where no sampler can do anything with them."""
    if stream.is_test:
        return bool(call(problem, stream, values, key="kind", seed=0, outputs=1).outputs)
    ends = [np.asarray(value.q) for value in values if isinstance(value, Configuration)]
    if len(ends) != 2:
        return TABLE if TABLE in values else ANY
    checker = arm_checker(problem.scene, values, fluents_of(problem, stream, values), margin=ARM_MARGIN)
    if not all(map(checker.free, ends)):
        return None
    return "free" if checker.path_free(np.array(ends)) else "in the way"
