from __future__ import annotations

import pytest

from tamp.streams.values import Placement
from tamp.task import Pose


@pytest.mark.parametrize(("pose", "on"), [(Pose((0.0, 0.0, 0.1)), "table"), ((0.0, 0.0, 0.1), ("table",))])
def test_a_placement_is_refused_whose_names_are_one_text_or_whose_pose_is_none(pose, on):
    with pytest.raises(TypeError, match="a tuple of names such as"):
        Placement(pose, on)
