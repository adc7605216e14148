import time
from types import SimpleNamespace

import pytest

from tamp.pipeline import asking, nearness
from tamp.pipeline.asking import Asker
from tamp.pipeline.attempt import Attempt
from tamp.pipeline.nearness import bring_near
from tamp.pipeline.progress import Progress
from tamp.pipeline.setup import prepare
from tamp.scoring.ede import ede, mean_edge
from tamp.streams.values import Placement
from tamp.task import At, Box, Object, Pose, Task, load_robot

BLOCK = Object("block", Box((0.16, 0.16, 0.1)), Pose((0.1, 0.25, 0.05)), At(Pose((0.1, 0.0, 0.05))))
"""No hand takes it, so that what shall rest on it never can."""
SLAB = Object("slab", Box((0.12, 0.16, 0.03)), Pose((0.0, -0.4, 0.015)), At(Pose((0.1, 0.0, 0.115))))
CUBE = Object("cube", Box((0.05, 0.05, 0.05)), Pose((0.0, -0.2, 0.025)), At(Pose((0.1, 0.0, 0.125))))


@pytest.mark.parametrize(("obj", "actions"), [(CUBE, {"pick", "place"}), (SLAB, {"slide", "pick"})])
def test_what_cannot_rest_where_it_shall_is_brought_near_even_if_it_has_to_be_slid_first(obj, actions):
    setup = prepare(Task("near", (BLOCK, obj)))
    attempt = Attempt.of(setup, setup.start, load_robot("panda").home, None)
    asker = Asker(Progress(attempt), seed=0, deadline=time.monotonic() + 600.0, algorithm="adaptive")
    assert bring_near(asker, {obj.name}, set())
    here = asker.workspace.start[obj.name].pose
    assert ede(mean_edge(obj.shape), here, obj.goal.pose) < 0.15
    assert actions <= {action.name for action in asker.progress.actions}


def test_what_nothing_comes_of_leaves_time_to_the_others(monkeypatch):
    """On a clock on which each of three objects uses all the time that it is given."""
    clock, given = [0.0], []

    def in_vain(asker, name, *_):
        given.append((name, asker.deadline - clock[0]))
        clock[0] = asker.deadline
        return False

    monkeypatch.setattr(asking, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    monkeypatch.setattr(nearness, "farthest_first", lambda workspace, names: sorted(names))
    monkeypatch.setattr(nearness, "_bring_near", in_vain)
    asker = Asker(SimpleNamespace(now=SimpleNamespace(workspace=None)), seed=0, deadline=24.0, algorithm="adaptive")
    assert not bring_near(asker, {"a", "b", "c"}, ())
    assert given == [("a", 12.0), ("b", 6.0), ("c", nearness.LEAST)]
    assert asker.deadline == 24.0


def looked_into(monkeypatch, places, serves):
    """The places that the planner is asked for in vain, each with how many grasps, and those that are looked at."""
    asked, looked = [], []

    def serving(place):
        looked.append(place)
        return ("grasp",) * (place in serves)

    grips = SimpleNamespace(grasps=("grasp",), fits=None, roomy=lambda place: ("grasp",), serving=serving)
    monkeypatch.setattr(nearness, "Grips", lambda *args: grips)
    monkeypatch.setattr(nearness, "substitutes", lambda *args: iter(places))
    monkeypatch.setattr(nearness, "_put", lambda asker, name, place, kept, grasps: asked.append((place, len(grasps))))
    asker = SimpleNamespace(workspace=None, drawn_seed=0, deadline=1.0, late=False)
    asker.progress = SimpleNamespace(now=SimpleNamespace(samplers={}))
    assert not nearness._bring_near(asker, "object", (), ())
    return asked, looked


def inside(x, roll=0.0):
    return Placement(Pose.from_rpy((x, 0.0, 0.1), (roll, 0.0, 0.0)), ("crate",))


def test_where_a_hand_can_put_it_is_tried_before_where_nobody_knows(monkeypatch):
    unknown, known = inside(0.0), inside(0.1)
    assert looked_into(monkeypatch, [unknown, known], [known])[0] == [(known, 1), (unknown, 0)]


def test_a_face_on_which_the_arm_cannot_put_it_is_not_looked_at_for_ever(monkeypatch):
    on_one_face, on_another = [inside(0.01 * i) for i in range(9)], inside(0.2, roll=1.0)
    looked = looked_into(monkeypatch, [*on_one_face, on_another], [on_another])[1]
    assert looked == [*on_one_face[: nearness.VAIN], on_another]


def test_where_others_shall_be_is_kept_free():
    setup = prepare(Task("near", (BLOCK, CUBE)))
    workspace = Attempt.of(setup, setup.start, load_robot("panda").home, None).workspace
    there, beside = (Placement(Pose((x, 0.0, 0.025)), ("table",)) for x in (0.12, -0.1))
    assert nearness._covers(workspace, "cube", there, {"block"})
    assert not nearness._covers(workspace, "cube", beside, {"block"})
    assert not nearness._covers(workspace, "cube", there, ())
