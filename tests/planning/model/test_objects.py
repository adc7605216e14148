from __future__ import annotations

import numpy as np

from tamp.planning.model.content import content
from tamp.planning.model.objects import Objects


def test_a_string_has_the_same_key_whatever_else_is_spoken_of():
    few, many = Objects(), Objects()
    for value in (1.0, ("a", "b"), "cup"):
        many.intern(value)
    assert few.key(few.intern("cup")) == many.key(many.intern("cup")) == "cup"


def test_values_of_other_kinds_are_told_apart_by_when_they_came_first():
    objects = Objects()
    one, other = objects.intern(1.0), objects.intern((2.0,))
    assert objects.key(one) != objects.key(other)
    assert objects.intern(1.0) == one


def test_what_streams_give_is_told_apart_by_what_it_consists_of():
    objects = Objects()
    pose = lambda x: {"base": (np.array([x, 0.0]), ["a"])}  # noqa: E731  has no hash
    one = objects.intern(pose(1.0), "stream[0]")
    assert objects.intern(pose(1.0), "stream[1]") == one == objects.find(objects.value(one))
    assert objects.intern(pose(2.0), "stream[2]") != one
    assert objects.intern(np.zeros(2), "stream[3]") != objects.intern(np.zeros(2, dtype=int), "stream[4]")


def test_what_the_problem_gives_without_a_hash_stands_for_itself():
    objects = Objects()
    assert objects.intern(np.zeros(2)) != objects.intern(np.zeros(2))


def test_content_is_unknown_where_equality_is_only_in_code():
    class Odd:
        __hash__ = None

    assert content(Odd()) is None and content([Odd()]) is None
    assert content(np.array([1, "a"], dtype=object)) == content(np.array([1, "a"], dtype=object)) is not None
    assert content([1]) != content((1,)) and content({1: [2]}) == content({1: [2]}) != content({1: [3]})
