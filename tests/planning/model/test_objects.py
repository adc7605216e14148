from __future__ import annotations

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
