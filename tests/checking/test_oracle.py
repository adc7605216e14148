"""The oracle that proves the checker: it passes the valid plan and sees through corruptions, by its own means."""

from __future__ import annotations

import numpy as np
import pytest

from tests.checking.handmade import two_boxes
from tests.checking.mutations import MUTATIONS, Mutation


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation.__name__)
def test_what_a_mutation_makes_is_wrong(mutation: Mutation) -> None:
    pytest.importorskip("pinocchio")
    from tests.checking.oracle import wrong

    mutant = mutation(*two_boxes(), np.random.default_rng(0))
    assert mutant is not None
    assert wrong(*mutant) is not None


def test_a_valid_plan_is_not() -> None:
    pytest.importorskip("pinocchio")
    from tests.checking.oracle import wrong

    assert wrong(*two_boxes()) is None
