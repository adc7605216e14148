"""Incremental joins agree with brute force, whatever the order in which facts arrive."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.planning.grounding.datalog import EVERY, Join, JoinRule, join_order

VARIABLES = ("?x", "?y", "?z")
TERMS = st.sampled_from([*VARIABLES, 0, 1])
PATTERNS = st.one_of(st.tuples(st.just("p"), TERMS), st.tuples(st.sampled_from(["q", "r"]), TERMS, TERMS))
FACTS = st.one_of(
    st.tuples(st.just("p"), st.integers(0, 2)),
    st.tuples(st.sampled_from(["q", "r"]), st.integers(0, 2), st.integers(0, 2)),
)


def brute_force(body, unequal, variables, facts):
    found = set()
    for values in itertools.product(range(3), repeat=len(variables)):
        binding = dict(zip(variables, values, strict=True))
        ground = {(p[0], *(binding.get(t, t) for t in p[1:])) for p in body}
        if ground <= set(facts) and all(binding.get(a, a) != binding.get(b, b) for a, b in unequal):
            found.add(values)
    return found


@settings(max_examples=150, deadline=None)
@given(st.lists(PATTERNS, min_size=1, max_size=3), st.lists(FACTS, max_size=14, unique=True), st.booleans())
def test_every_match_once(body, facts, apart):
    variables = tuple(dict.fromkeys(t for p in body for t in p[1:] if isinstance(t, str)))
    unequal = (variables[:2],) if apart and len(variables) > 1 else ()
    found = []
    join = Join([JoinRule(variables, tuple(body), unequal, found.append)])
    for fact in facts:
        join.add(fact)
        join.add(fact)
    assert len(found) == len(set(found))
    assert set(found) == brute_force(body, unequal, variables, facts)


@settings(max_examples=80, deadline=None)
@given(st.lists(PATTERNS, min_size=1, max_size=3), st.lists(FACTS, max_size=14, unique=True), st.integers(1, 3))
def test_a_join_that_pauses_misses_nothing(body, facts, portion):
    variables = tuple(dict.fromkeys(t for p in body for t in p[1:] if isinstance(t, str)))
    found, room = [], portion
    join = Join([JoinRule(variables, tuple(body), (), found.append)])
    join.paused = lambda: len(found) >= room
    for fact in facts:
        join.add(fact)
        assert len(found) <= room
    while join.unfinished:
        room = len(found) + portion
        join.run()
        assert len(found) <= room
    assert not join.broken
    assert len(found) == len(set(found))
    assert set(found) == brute_force(body, (), variables, facts)


def test_what_shares_a_variable_is_looked_up_before_what_shares_none():
    body = (("at", "?x"), ("kind", "?k"), ("link", "?x", "?y", "?k", "?z"))
    steps = join_order(("?x", "?k", "?y", "?z"), body, (), 0)
    assert [body[step.position][0] for step in steps] == ["at", "link", "kind"]


def test_facts_added_while_matching_are_matched_too():
    found = []
    join = Join([])

    def next_number(values):
        found.append(values[0])
        if values[0] < 5:
            join.add(("p", values[0] + 1))

    join = Join([JoinRule(("?x",), (("p", "?x"),), (), next_number)])
    join.add(("p", 0))
    assert found == [0, 1, 2, 3, 4, 5]


def test_the_tick_can_end_a_join_of_any_rule() -> None:
    class EnoughError(Exception):
        """The limit of a run."""

    def tick() -> None:
        raise EnoughError

    found = []
    join = Join([JoinRule(("?x", "?y"), (("p", "?x"), ("p", "?y")), (), found.append)])
    join.tick = tick
    with pytest.raises(EnoughError):
        for i in range(100):
            join.add(("p", i))
    assert len(found) < 2 * EVERY


@given(st.lists(st.integers(0, 3), max_size=12))
def test_facts_that_wait_come_by_their_turns_and_then_as_they_came(turns):
    seen, waiting = [], True
    join = Join([JoinRule(("?x",), (("p", "?x"),), (), lambda values: seen.append(values[0]))])
    join.paused = lambda: waiting
    for number, turn in enumerate(turns):
        join.add(("p", number), turn)
    waiting = False
    join.run()
    assert seen == sorted(range(len(turns)), key=turns.__getitem__)
