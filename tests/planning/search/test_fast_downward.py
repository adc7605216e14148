"""Searches for cheaper plans come first, as long as tasks are small enough for them."""

import math
import re

import pytest

from tamp.planning.grounding.ground_task import GroundTask, TaskEffect, TaskOperator
from tamp.planning.search import fast_downward
from tamp.planning.search.fast_downward import Cheap, FastDownward

NEVER = "let(h, ff(), lazy_greedy([h], max_time=0{bound}))"
BEST = "astar(blind(){bound})"
SLOW = "let(h, blind(), eager(single(h), max_time={seconds}{bound}))"


def line(n: int) -> GroundTask:
    """n steps that each cost 1, one after the other."""
    steps = tuple(TaskOperator(None, (i,), (), (TaskEffect(i + 1, True),), 1) for i in range(n))
    return GroundTask(tuple(("p", i) for i in range(n + 1)), frozenset({0}), (n,), (), steps, ())


@pytest.fixture
def asked(monkeypatch):
    """The searches that were run, of which the first finds nothing."""
    found = []
    run = fast_downward._run

    def note(text, search, *rest):
        found.append(search)
        return run(text, search, *rest)

    monkeypatch.setattr(fast_downward, "_run", note)
    monkeypatch.setitem(fast_downward.CHEAP, "ff", (Cheap(NEVER, 9, 0, 0.0), Cheap(BEST, 99, 10_000, 0.1)))
    return found


def test_the_next_search_is_asked_where_a_cheap_one_finds_nothing(asked):
    assert len(FastDownward("ff")(line(3), 10.0).plan or ()) == 3
    assert asked == [NEVER.format(bound=""), BEST.format(bound="")]


def test_what_was_in_vain_is_not_tried_on_what_is_no_smaller(asked):
    search = FastDownward("ff")
    for n in (3, 4, 2):
        asked.clear()
        assert len(search(line(n), 10.0).plan or ()) == n
        assert len(asked) == (1 if n == 4 else 2)


def test_large_tasks_get_no_cheap_search(asked):
    assert len(FastDownward("ff")(line(100), 10.0).plan or ()) == 100
    assert asked == [fast_downward.CONFIGURATIONS["ff"].format(bound="")]


def grid(n: int, side: int) -> GroundTask:
    """A counter in each of n places, which goes up by steps of 1 to a last number that is wanted."""
    atoms = tuple(("p", i, k) for i in range(n) for k in range(side))
    number = {atom: i for i, atom in enumerate(atoms)}
    steps = []
    for i in range(n):
        for k in range(side - 1):
            before, after = number["p", i, k], number["p", i, k + 1]
            effects = (TaskEffect(before, False), TaskEffect(after, True))
            steps.append(TaskOperator(None, (before,), (), effects, 1))
    initial = frozenset(number["p", i, 0] for i in range(n))
    goal = tuple(number["p", i, side - 1] for i in range(n))
    groups = tuple(tuple(number["p", i, k] for k in range(side)) for i in range(n))
    return GroundTask(atoms, initial, goal, (), tuple(steps), (), groups)


@pytest.mark.parametrize(("work", "cheaply"), [(10**9, True), (100, False)])
def test_states_are_counted_so_that_the_machine_does_not_matter(monkeypatch, asked, work, cheaply):
    """Whatever time it is given first, what a cheap search finds depends on the states alone that it may see."""
    monkeypatch.setattr(fast_downward, "STATES", work)
    plans = set()
    for seconds in (0.0005, 5.0):
        asked.clear()
        monkeypatch.setitem(fast_downward.CHEAP, "ff", (Cheap(SLOW, 99, work, seconds),))
        plans.add(FastDownward("ff")(grid(3, 16), 60.0).plan)
        assert (asked[-1] == fast_downward.CONFIGURATIONS["ff"].format(bound="")) != cheaply
    assert len(plans) == 1


def test_what_a_cheap_search_has_exhausted_is_not_searched_again(asked, monkeypatch):
    monkeypatch.setitem(fast_downward.CHEAP, "ff", (Cheap(BEST, 9, 10_000, 0.1), Cheap(BEST, 99, 10_000, 0.1)))
    task = line(4)
    barred = TaskOperator(None, (3,), (0,), (TaskEffect(4, True),), 1)
    end = FastDownward("ff")(
        GroundTask(task.atoms, task.initial, (4,), (), (*task.operators[:3], barred), (), ()), 10.0
    )
    assert (end.plan, end.proven, len(asked)) == (None, True, 1)


def seconds_of(search: str) -> float:
    """The processor time that a search was given; none for one without end."""
    found = re.search(r"max_time=([\d.e-]+)", search)
    return float(found[1]) if found else math.inf


def test_cheap_searches_are_given_as_much_time_as_states_took_before(monkeypatch, asked):
    """Of a small task each saw ten times as many states as it may find a plan among, for a second in all."""
    monkeypatch.setattr(fast_downward, "STATES", 100)
    monkeypatch.setitem(fast_downward.CHEAP, "ff", (Cheap(SLOW, 99, 10**9, 5.0), Cheap(SLOW, 99, 10**9, 5.0)))
    assert FastDownward("ff")(grid(3, 16), 60.0).plan
    assert seconds_of(asked[0]) == 5.0
    assert seconds_of(asked[1]) < 1.0


def test_where_another_search_follows_the_last_try_is_no_longer_than_those_before(monkeypatch, asked):
    """As many places as cannot be filled in the time of the cheap searches: they are not called unsolvable."""
    monkeypatch.setattr(fast_downward, "STATES", 100)
    monkeypatch.setitem(fast_downward.CHEAP, "ff", (Cheap(SLOW, 999, 10**9, 0.25), Cheap(SLOW, 999, 10**9, 0.25)))
    monkeypatch.setitem(fast_downward.CONFIGURATIONS, "ff", BEST)
    result = FastDownward("ff")(grid(6, 16), 60.0, effort=1.0)
    assert seconds_of(asked[-1]) <= 0.5
    assert not result.proven
    assert result.timed_out
