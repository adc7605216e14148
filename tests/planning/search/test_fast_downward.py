"""Searches for cheaper plans come first, as long as tasks are small enough for them."""

import pytest

from tamp.planning.grounding.ground_task import GroundTask, TaskEffect, TaskOperator
from tamp.planning.search import fast_downward
from tamp.planning.search.fast_downward import FastDownward

NEVER = "let(h, ff(), lazy_greedy([h], max_time=0{bound}))"
BEST = "astar(blind(){bound})"


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
    monkeypatch.setitem(fast_downward.CHEAP, "ff", ((9, NEVER), (99, BEST)))
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
