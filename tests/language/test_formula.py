import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.language import Atom, Constant, Variable

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=True) | st.text(),
    lambda inner: st.tuples(inner, inner) | st.lists(inner, max_size=2),
    max_leaves=4,
)


@given(VALUES, VALUES)
def test_constants_equal_as_their_values_do(left, right):
    a, b = Constant(left), Constant(right)
    assert a == Constant(left)
    if a == b:
        assert hash(a) == hash(b)
    hashable = True
    try:
        hash((left, right))
    except TypeError:
        hashable = False
    if hashable:
        assert (a == b) == (left == right or left is right)


def test_arrays_are_compared_by_identity():
    array, twin = np.zeros(2), np.zeros(2)
    assert Constant(array) == Constant(array)
    assert Constant(array) != Constant(twin)
    assert len({Constant(array), Constant(array), Constant(twin), Constant((array,)), Constant((array,))}) == 4


def test_everything_is_immutable():
    constant = Constant([1])
    with pytest.raises(AttributeError, match="immutable"):
        constant.value = 2
    with pytest.raises(dataclasses.FrozenInstanceError):
        Atom("p", ()).predicate = "q"
    assert constant != "a" and Variable("?x") != Constant("?x")


def test_atoms_read_as_they_are_written():
    assert str(Atom("on", (Variable("?x"), Constant("a")))) == "(on ?x a)"
