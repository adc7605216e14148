from __future__ import annotations

import itertools
import math
import time
from types import SimpleNamespace

import numpy as np
import pytest

from tamp.streams.cache import WORK, SampleCache, pausing, recalled, stepwise


def scene(cache, **standing):
    return SimpleNamespace(cache=cache, placements=tuple(standing.items()))


def context(seed=0, deadline=math.inf):
    reasons = []
    rng = np.random.default_rng(99)
    return SimpleNamespace(
        seed=seed, rng=rng, deadline=deadline, fluents=(), bound=(), fail=reasons.append, told=reasons
    )


def squares(begun):
    def draw(context):
        begun.append(1)
        for number in range(3):
            context.fail(f"skipped {number}")
            yield number**2

    return draw


def draws(context):
    while True:
        yield float(context.rng.random())


def test_every_reader_sees_all_samples_and_all_reasons_and_they_are_drawn_once():
    table, begun = scene(SampleCache()), []
    first, second = context(), context()
    assert list(itertools.islice(recalled(first, "squares", (), table, squares(begun)), 2)) == [0, 1]
    assert list(recalled(second, "squares", (), table, squares(begun))) == [0, 1, 4]
    assert second.told == ["skipped 0", "skipped 1", "skipped 2"]
    assert first.told == second.told[:2]
    assert len(begun) == 1


def test_whoever_comes_later_hears_no_reason_before_its_sample():
    table, begun = scene(SampleCache()), []
    list(recalled(context(), "squares", (), table, squares(begun)))
    late = context()
    next(recalled(late, "squares", (), table, squares(begun)))
    assert late.told == ["skipped 0"]


def test_readers_may_take_turns():
    table, begun = scene(SampleCache()), []
    a, b = (recalled(context(), "squares", (), table, squares(begun)) for _ in range(2))
    assert [next(a), next(b), next(b), next(a), next(a), next(b)] == [0, 0, 1, 1, 4, 4]


def test_a_deadline_ends_one_reading_only():
    table, begun = scene(SampleCache()), []
    assert list(recalled(context(deadline=0.0), "squares", (), table, squares(begun))) == []
    assert list(recalled(context(), "squares", (), table, squares(begun))) == [0, 1, 4]


@pytest.mark.parametrize(
    "other",
    [
        {"name": "others"},
        {"inputs": ("b",)},
        {"seed": 1},
        {"table": {"cube": 0.1}},
    ],
)
def test_another_name_input_seed_or_scene_has_other_samples_and_the_same_has_the_same(other):
    cache = SampleCache()

    def first(name="draws", inputs=("a",), seed=0, table=None, cache=cache):
        reads = scene(cache, **(table or {"cube": 0.0}))
        return next(recalled(context(seed), name, inputs, reads, draws))

    assert first(**other) != first() == first(cache=SampleCache())


def test_samples_do_not_depend_on_the_generator_of_whoever_asks_first():
    first, second = context(), context()
    first.rng.random(7)
    assert [next(recalled(c, "draws", (), scene(SampleCache()), draws)) for c in (first, second)] == [
        next(recalled(context(), "draws", (), scene(SampleCache()), draws))
    ] * 2


def test_what_is_drawn_sees_no_more_of_the_scene_than_was_declared():
    seen = []

    def draw(context):
        seen.append(context.scene)
        yield 1

    part = scene(SampleCache(), cube=0.0)
    asking = context()
    asking.scene = scene(part.cache, cube=0.0, cup=1.0)
    assert list(recalled(asking, "seen", (), part, draw)) == [1]
    assert seen == [part]


def test_a_reader_whose_deadline_passes_stops_at_the_next_pause():
    """The sampler's own clock runs here: it is past the deadline before anything has come."""
    paused, table = [], scene(SampleCache())

    def slow(_):
        for _ in range(5):
            paused.append(1)
            time.sleep(0.002)
            yield None
        yield "late"

    assert list(recalled(context(deadline=time.monotonic() + 0.001), "slow", (), table, slow)) == []
    assert len(paused) < 5
    assert list(recalled(context(), "slow", (), table, slow)) == ["late"]
    assert len(paused) == 5


def test_pauses_show_to_all_who_step_so_that_patience_ends_alike_for_all():
    def draw(_):
        yield from (None, 1, None, 2)

    table = scene(SampleCache())
    for _ in range(2):
        assert list(stepwise(context(), "pauses", (), table, draw)) == [None, 1, None, 2]


@pytest.mark.parametrize("interrupted", range(5))
def test_a_sampler_that_was_interrupted_goes_on_as_if_it_had_not_been(interrupted):
    table, steps = scene(SampleCache()), itertools.count()

    def draw(context):
        for number in range(5):
            if next(steps) == interrupted:
                raise TimeoutError
            context.fail(f"skipped {number}")
            yield number, float(context.rng.random())

    first, second, undisturbed = context(), context(), context()
    with pytest.raises(TimeoutError):
        list(recalled(first, "draws", (), table, draw))
    found = list(recalled(second, "draws", (), table, draw))
    assert found == list(recalled(undisturbed, "draws", (), scene(SampleCache()), draw))
    assert [number for number, _ in found] == list(range(5))
    assert second.told == undisturbed.told


def test_a_value_is_worked_out_once():
    cache, asked = SampleCache(), []

    def work_out():
        asked.append(1)

    assert [cache.value("nothing", work_out) for _ in range(3)] == [None] * 3
    assert len(asked) == 1


def pauses_of(steps, **given):
    """What `pausing` gives, and how often it said that it paused."""
    said = []
    reader = SimpleNamespace(**{"deadline": math.inf, **given}, pause=lambda: said.append(1))
    return list(pausing(reader, steps)), len(said)


def test_a_sampler_pauses_where_no_plan_waits_for_it():
    steps = [*[None] * (2 * WORK + 1), "found", *[None] * WORK]
    assert pauses_of(steps, brief=True) == ([None, None, "found", None], 3)
    assert pauses_of(steps, brief=False) == (["found"], 0)


def test_whoever_pauses_minds_the_deadline():
    assert pauses_of(["found", None, "late"], brief=False, deadline=-math.inf) == (["found"], 0)
