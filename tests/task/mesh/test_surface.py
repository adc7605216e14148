"""Questions about a triangulated surface."""

from itertools import product

import numpy as np
import pytest

from tamp.task.mesh.parts import convex_hull
from tamp.task.mesh.surface import closed, oriented, volume


def test_a_box_is_closed_and_encloses_its_volume_wherever_it_is() -> None:
    box = convex_hull(np.array(list(product((1.0, 1.2), (-3.0, -2.7), (0.0, 0.5)))))
    assert closed(box.vertices, box.faces) and oriented(box.faces)
    assert volume(box.vertices, box.faces) == pytest.approx(0.2 * 0.3 * 0.5)


def test_a_triangle_that_is_seen_from_behind_or_missing_is_found() -> None:
    box = convex_hull(np.array(list(product((0.0, 1.0), repeat=3))))
    turned = np.concatenate([box.faces[:1, ::-1], box.faces[1:]])
    assert closed(box.vertices, turned) and not oriented(turned)
    assert not closed(box.vertices, box.faces[1:]) and not oriented(box.faces[1:])
