from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamp.generate.placement.contact import hits, on_table
from tamp.generate.placement.fitting import fits
from tamp.generate.placement.object_model import thing, yawed
from tamp.generate.placement.relations import GAP, draw_place
from tamp.generate.placement.request import Wish
from tamp.scenarios.library.model import read_library

THINGS = {model.kind: thing(model) for model in read_library() if model.set == "trial"}
PAIRS = [
    ("cup", "on", "saucer"),
    ("apple", "in", "basket"),
    ("marker", "standing", "penholder"),
    ("plate", "stacked", "plate"),
    ("fork", "around", "plate"),
    ("jar", "row", "carton"),
    ("banana", "beside", "bowl"),
    ("book", "leaning", "carton"),
]


def placed(child: str, relation: str, parent: str, seed: int):
    """Child and parent, each with its pose, by one draw."""
    rng = np.random.default_rng(seed)
    base = THINGS[parent]
    T_parent = on_table(base, yawed(base.resting[0], rng.uniform(-3, 3)), (0.1, -0.2))
    wish = Wish(THINGS[child], base, T_parent, [(base, T_parent)], 0, 2, rng)
    return THINGS[child], draw_place(relation, wish), base, T_parent


@pytest.mark.parametrize(("child", "relation", "parent"), PAIRS)
@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_what_is_placed_is_in_nothing_and_near_its_parent(child, relation, parent, seed):
    item, T, base, T_parent = placed(child, relation, parent, seed)
    assert fits(relation, item, base)
    assert not hits(item, T, [(base, T_parent)])
    nearest = 0.003 if relation in ("on", "in", "standing", "stacked", "leaning") else 2 * GAP[1]
    assert hits(item, T, [(base, T_parent)], nearest)
    assert (item.points @ T[2, :3]).min() + T[2, 3] > 0


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_neighbours_leave_room_for_a_finger(seed):
    for child, relation, parent in (("can", "row", "can"), ("spoon", "around", "plate"), ("cup", "beside", "bottle")):
        item, T, base, T_parent = placed(child, relation, parent, seed)
        assert not hits(item, T, [(base, T_parent)], 0.9 * GAP[0])
