"""Without the check that is for it a corrupted plan is accepted, and the oracle still calls it wrong.

So the oracle would tell of a checker that forgets what it is to look for.
"""

from __future__ import annotations

import numpy as np
import pytest

from tamp.checking import check
from tamp.checking.actions import arm_motion, fall, left_standing
from tamp.checking.actions.collisions import pairs
from tamp.checking.physics.round_bodies import perching
from tests.checking.handmade import two_boxes
from tests.checking.mutations.handling import (
    hangs_lower_than_said,
    lies_tilted_across_two_trays,
    lies_tilted_in_a_tray,
    met_where_it_was_let_go,
    rocks_over_its_foot,
    rocks_under_what_is_put_on_it,
    takes_a_board_over_the_rim,
    takes_a_prop_away,
    tips_against_what_leans,
    tips_off_a_rim,
)
from tests.checking.mutations.rounds import rolls_along_a_groove, rolls_off_half_a_rim


@pytest.mark.parametrize(
    ("mutation", "where", "answers"),
    [
        (rocks_over_its_foot, fall, {"tips_on": None}),
        (hangs_lower_than_said, pairs, {"_hanging": None}),
        (rolls_along_a_groove, perching, {"_rolls_down": False}),
        (rolls_off_half_a_rim, perching, {"_rolls_down": False}),
        (met_where_it_was_let_go, arm_motion, {"astray": []}),
        (rocks_under_what_is_put_on_it, arm_motion, {"_let_follow": None}),
        (takes_a_board_over_the_rim, left_standing, {"over_edge": [], "_note_given_way": None}),
        (takes_a_prop_away, left_standing, {"_giving_way": ()}),
        (lies_tilted_in_a_tray, left_standing, {"_goes_on": False}),
        (lies_tilted_across_two_trays, left_standing, {"_goes_on": False}),
        (tips_against_what_leans, left_standing, {"gives_way": ()}),
        (tips_off_a_rim, left_standing, {"_goes_on": False}),
    ],
)
def test_the_oracle_alone_tells_of_it(monkeypatch, mutation, where, answers):
    pytest.importorskip("pinocchio")
    from tests.checking.oracle import wrong

    mutant = mutation(*two_boxes(), np.random.default_rng(2))
    assert not check(*mutant).accepted
    for switched_off, answer in answers.items():
        monkeypatch.setattr(where, switched_off, lambda *_, answer=answer, **__: answer)
    assert check(*mutant).accepted, str(check(*mutant))
    assert wrong(*mutant) is not None
