"""Benchmarks of perception look with some of a set-up's cameras, from some of their viewpoints."""

from __future__ import annotations

import pytest

from benchmarks.parts.cameras import some_cameras
from tamp.perception.cameras.setup import load_setup


def test_all_look_where_nothing_is_said() -> None:
    assert some_cameras(load_setup()) == tuple(load_setup())


def test_the_named_ones_look_from_their_first_viewpoints() -> None:
    arm = next(camera for camera in load_setup() if camera.viewpoints)
    (only,) = some_cameras(load_setup(), [arm.name], 2)
    assert only.name == arm.name
    assert only.viewpoints == arm.viewpoints[:2]


@pytest.mark.parametrize(("names", "viewpoints", "said"), [(["kinekt"], 0, "kinekt"), ([], -1, "viewpoints")])
def test_what_is_not_there_is_told(names: list[str], viewpoints: int, said: str) -> None:
    with pytest.raises(SystemExit, match=said):
        some_cameras(load_setup(), names, viewpoints)
