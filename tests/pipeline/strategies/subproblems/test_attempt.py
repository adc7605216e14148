"""What the checker is asked of a placement before planning, and what it is not."""

from __future__ import annotations

import pytest
import trimesh

from tamp.pipeline.prepare import Setup, prepare
from tamp.pipeline.strategies.subproblems.attempt import Attempt
from tamp.streams.values import Placement
from tamp.task import Box, Object, Pose, Task, load_robot
from tests.checking.test_given_way import written

LEVEL, TILTED = (0.0, 0.0, 0.0), (0.0, 0.15, 0.0)


@pytest.mark.parametrize(
    ("on", "x", "z", "turned", "asked"),
    [
        (("table",), -0.1, 0.0, LEVEL, False),
        (("left",), 0.0, 0.05, LEVEL, False),
        (("left", "right"), 0.06, 0.05, LEVEL, True),
        (("table",), -0.1, 0.01, TILTED, True),
    ],
    ids=["on the table", "on another", "across two", "tilted"],
)
def test_what_plainly_stands_is_not_asked_about(monkeypatch, tmp_path, on, x, z, turned, asked):
    """A thing of two pieces, such as contacts within millimetres say little of."""
    pieces = [trimesh.creation.box((0.08, 0.06, 0.02)), trimesh.creation.box((0.02, 0.06, 0.04))]
    for piece, height in zip(pieces, (0.01, 0.03), strict=True):
        piece.apply_translation((0.0, 0.0, height))
    block, places = Box((0.11, 0.08, 0.05)), (("left", 0.0), ("right", 0.12))
    blocks = [Object(name, block, Pose((at, 0.0, 0.025))) for name, at in places]
    task = Task("pieces", (*blocks, Object("thing", written(tmp_path / "thing.obj", pieces), Pose((0.0, 0.3, 0.0)))))
    setup, questions = prepare(task), []
    begin = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    monkeypatch.setattr(Setup, "stays", lambda self, name, poses: questions.append(name) or False)
    place = Placement(Pose.from_rpy((x, 0.0 if z >= 0.05 else -0.2, z), turned), on)
    assert begin.stays("thing", place) != asked
    assert questions == ["thing"] * asked
