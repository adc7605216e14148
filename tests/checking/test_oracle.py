"""The oracle that proves the checker: it passes the valid plan and sees through corruptions, by its own means."""

from __future__ import annotations

import numpy as np
import pytest

from tests.checking.handmade import scales, two_boxes
from tests.checking.mutations import MUTATIONS, STACKS, Mutation


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation.__name__)
def test_what_a_mutation_makes_is_wrong(mutation: Mutation) -> None:
    pytest.importorskip("pinocchio")
    from tests.checking.oracle import wrong

    mutant = mutation(*two_boxes(), np.random.default_rng(0))
    assert mutant is not None
    assert wrong(*mutant) is not None


@pytest.mark.parametrize("mutation", STACKS, ids=lambda mutation: mutation.__name__)
def test_a_stack_that_tips_is_wrong(mutation: Mutation) -> None:
    pytest.importorskip("pinocchio")
    from tests.checking.oracle import wrong

    assert all(wrong(*mutation(*scales(), np.random.default_rng(seed))) is not None for seed in range(3))


@pytest.mark.parametrize("made", [two_boxes, scales])
def test_a_valid_plan_is_not(made) -> None:
    pytest.importorskip("pinocchio")
    from tests.checking.oracle import wrong

    assert wrong(*made()) is None
