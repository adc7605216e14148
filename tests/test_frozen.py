"""Mappings of frozen data: they refuse changes, and are otherwise dicts."""

from __future__ import annotations

import copy
import json
import pickle

import pytest

from tamp.frozen import FrozenDict

CHANGES = (
    lambda d: d.__setitem__("a", 2),
    lambda d: d.__delitem__("a"),
    lambda d: d.update(a=2),
    lambda d: d.setdefault("b", 2),
    lambda d: d.pop("a"),
    lambda d: d.popitem(),
    lambda d: d.clear(),
    lambda d: d.__ior__({"a": 2}),
)


@pytest.mark.parametrize("change", CHANGES)
def test_it_refuses_changes(change):
    frozen = FrozenDict(a=1)
    with pytest.raises(TypeError, match="does not change"):
        change(frozen)
    assert frozen == {"a": 1}


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])
def test_a_copy_is_equal_and_as_frozen(copied):
    frozen = FrozenDict(a=[1])
    again = copied(frozen)
    assert again == frozen
    assert type(again) is FrozenDict


def test_it_is_hashed_by_content_and_written_as_json():
    assert hash(FrozenDict(a=1, b=2)) == hash(FrozenDict(b=2, a=1))
    assert json.dumps(FrozenDict(a=1)) == '{"a": 1}'
    with pytest.raises(TypeError):
        hash(FrozenDict(a=[]))
