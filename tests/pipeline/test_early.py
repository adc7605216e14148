import math

from tamp.pipeline import early
from tamp.pipeline.asking import Asker
from tamp.pipeline.attempt import Attempt
from tamp.pipeline.early import Early
from tamp.pipeline.progress import Progress
from tamp.pipeline.prospects import Prospects
from tamp.pipeline.setup import prepare
from tamp.task import At, Box, Object, Pose, Task, load_robot

RED = Object("red", Box((0.05, 0.05, 0.08)), Pose((0.05, 0.0, 0.04)), At(Pose((0.05, -0.2, 0.04))))
TOP = Object("top", Box((0.04, 0.04, 0.04)), Pose((0.15, 0.05, 0.02)), At(Pose((0.05, -0.2, 0.1))))
CUBE = Object("cube", Box((0.04, 0.04, 0.04)), Pose((0.15, 0.25, 0.02)), At(Pose((0.15, -0.3, 0.02))))
CLOSE = Object("close", Box((0.04, 0.04, 0.04)), Pose((-0.1, 0.2, 0.02)), At(Pose((-0.1, 0.3, 0.02))))


def test_what_has_no_hope_is_brought_near_once_if_far_and_not_to_where_others_shall_be(monkeypatch):
    setup = prepare(Task("far", (RED, TOP, CUBE, CLOSE)))
    asker = Asker(Progress(Attempt.of(setup, setup.start, load_robot("panda").home, None)), 0, math.inf, "adaptive")
    here, asked = asker.workspace.start, []
    monkeypatch.setattr(early, "bring_near", lambda _, names, __, free: asked.append((names, free)) or True)
    without_hope = Early(Prospects(asker, {name: (here[name], "no grasp") for name in ("red", "close")}))
    names = ["red", "top", "cube", "close"]
    assert not any(without_hope.bring(name, names, ()) for name in names)  # where all goals are asked for
    without_hope.allowed = True
    assert [without_hope.bring(name, names, ()) for name in (*names, "top")] == [True, True, False, False, False]
    assert asked == [({"red"}, {"cube"}), ({"top"}, {"cube"})]
