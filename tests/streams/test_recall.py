import itertools
import math
import time
from types import SimpleNamespace

import numpy as np

from tamp.streams.recall import recalled, stepwise


def context(memory, deadline=math.inf):
    reasons = []
    scene = SimpleNamespace(memory=memory)
    return SimpleNamespace(
        scene=scene,
        rng=np.random.default_rng(0),
        deadline=deadline,
        fluents=(),
        bound=(),
        fail=reasons.append,
        told=reasons,
    )


def squares(begun):
    def draw(context):
        begun.append(1)
        for number in range(3):
            context.fail(f"skipped {number}")
            yield number**2

    return draw


def test_every_reader_sees_all_samples_and_all_reasons_and_they_are_drawn_once():
    memory, begun = {}, []
    first, second = context(memory), context(memory)
    assert list(itertools.islice(recalled(first, "key", squares(begun)), 2)) == [0, 1]
    assert list(recalled(second, "key", squares(begun))) == [0, 1, 4]
    assert second.told == ["skipped 0", "skipped 1", "skipped 2"]
    assert first.told == second.told[:2]
    assert len(begun) == 1


def test_readers_may_take_turns():
    memory, begun = {}, []
    a, b = (recalled(context(memory), "key", squares(begun)) for _ in range(2))
    assert [next(a), next(b), next(b), next(a), next(a), next(b)] == [0, 0, 1, 1, 4, 4]


def test_a_deadline_ends_one_reading_only():
    memory, begun = {}, []
    assert list(recalled(context(memory, deadline=0.0), "key", squares(begun))) == []
    assert list(recalled(context(memory), "key", squares(begun))) == [0, 1, 4]


def test_other_keys_are_other_samples():
    memory, begun = {}, []
    assert list(recalled(context(memory), "a", squares(begun))) == list(recalled(context(memory), "b", squares(begun)))
    assert len(begun) == 2


def test_a_reader_whose_deadline_passes_stops_at_the_next_pause():
    """The sampler's own clock runs here: it is past the deadline before anything has come."""
    paused, memory = [], {}

    def slow(_):
        for _ in range(5):
            paused.append(1)
            time.sleep(0.002)
            yield None
        yield "late"

    assert list(recalled(context(memory, deadline=time.monotonic() + 0.001), "key", slow)) == []
    assert len(paused) < 5
    assert list(recalled(context(memory), "key", slow)) == ["late"]
    assert len(paused) == 5


def test_pauses_show_to_those_who_step():
    def draw(_):
        yield from (None, 1, None, 2)

    steps = context({})
    assert list(stepwise(steps, "key", draw)) == [None, 1, None, 2]
    assert list(stepwise(steps, "key", draw)) == [1, 2]
