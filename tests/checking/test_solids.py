"""Bodies and the robot's links: volumes, pieces, and who may touch whom."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.checking.links import read_links
from tamp.checking.solids import Solid
from tamp.task import Box, load_robot
from tamp.task.mesh import parts


def test_mass_of_a_box() -> None:
    volume, center = Solid.of("body", parts(Box((0.1, 0.2, 0.3)))).hull.volume_and_centroid
    assert volume == pytest.approx(0.006)
    assert np.allclose(center, 0.0, atol=1e-12)


def test_links_of_the_panda() -> None:
    links = read_links(load_robot("panda"))
    assert len(links.solids) == 11
    assert links.fixed == {"panda_link0"}
    assert links.gripper == {"panda_hand", "panda_leftfinger", "panda_rightfinger"}
    pairs = {frozenset((a.name, b.name)) for a, b in links.pairs}
    assert frozenset(("panda_link0", "panda_hand")) in pairs
    assert frozenset(("panda_link1", "panda_link2")) not in pairs
    assert frozenset(("panda_leftfinger", "panda_rightfinger")) not in pairs
