from __future__ import annotations

import pytest

from tamp.streams.affordances.support import stands_on
from tamp.streams.values import Placement
from tamp.task import Box, Object, Pose
from tests.streams.tables import workspace_of

LOW = Object("low", Box((0.1, 0.1, 0.04)), Pose((0.0, 0.0, 0.02)))
HIGH = Object("high", Box((0.06, 0.06, 0.1)), Pose((0.2, 0.0, 0.05)))


@pytest.mark.parametrize(("over", "steady"), [(0.0, True), (0.044, True), (0.047, False), (0.055, False)])
def test_what_is_hardly_in_balance_on_something_is_not_steady_there(over, steady):
    workspace = workspace_of(LOW, HIGH)
    placement = Placement(Pose((over, 0.0, 0.091)), ("low",))
    assert stands_on(workspace, "high", placement, {"low": workspace.start["low"]}) == steady
