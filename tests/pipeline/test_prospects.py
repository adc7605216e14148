import time

import pytest

from tamp.pipeline.asking import Asker
from tamp.pipeline.attempt import Attempt
from tamp.pipeline.ordering import Ordering
from tamp.pipeline.progress import Progress
from tamp.pipeline.prospects import Prospects
from tamp.pipeline.setup import prepare
from tamp.task import At, Box, Object, Pose, Task, load_robot
from tests.pipeline.samplers import no_slide

UPSIDE_DOWN = (1.0, 0.0, 0.0, 0.0)
BOARD = Object("board", Box((0.3, 0.3, 0.02)), Pose((-0.05, 0.3, 0.01)), At(Pose((-0.05, 0.3, 0.01), UPSIDE_DOWN)))
RED = Object("red", Box((0.05, 0.05, 0.08)), Pose((0.05, 0.0, 0.04)), At(Pose((0.05, -0.2, 0.04))))


@pytest.fixture
def attempt():
    """A board that no hand can turn over, and a block."""
    setup = prepare(Task("turn", (BOARD, RED)))
    return Attempt.of(setup, setup.start, load_robot("panda").home, {"plan-sliding": no_slide})


def prospects(attempt, seconds=600.0):
    return Prospects(Asker(Progress(attempt), 0, time.monotonic() + seconds, "adaptive"))


def test_what_does_not_get_to_its_goal_even_alone_is_remembered_with_a_reason(attempt):
    found = prospects(attempt)
    assert found.known_against("board") is None
    why = found.against("board")
    assert why.startswith("even alone: ")
    asked = len(found.asker.reports)
    assert found.against("board") == found.known_against("board") == why
    assert found.against("red") is None
    assert found.known_against("red") is None
    assert set(found.hopeless) == {"board"}
    assert len(found.asker.reports) == asked + 1


def test_what_time_cut_short_is_not_remembered(attempt):
    found = prospects(attempt, seconds=0.0)
    assert found.against("red") is not None
    assert found.hopeless == {}


@pytest.mark.parametrize(("hopeless", "first"), [({}, "board"), ({"board": "even alone: no grasp"}, "red")])
def test_what_is_known_to_be_hopeless_is_not_tried_before_all_else(attempt, monkeypatch, hopeless, first):
    class AskedError(Exception):
        pass

    def ask(self, workspace, *_, **__):
        raise AskedError(*(obj.name for obj in workspace.task.objects if obj.goal is not None))

    monkeypatch.setattr(Asker, "ask", ask)
    ordering = Ordering(attempt, 0, time.monotonic() + 600.0, "adaptive", hopeless)
    with pytest.raises(AskedError) as asked:
        ordering.run()
    assert asked.value.args == (first,)


def test_beyond_hope_is_also_what_shall_rest_on_what_is_hopeless():
    top = Object("top", Box((0.04, 0.04, 0.04)), Pose((0.15, 0.05, 0.02)), At(Pose((0.05, -0.2, 0.1))))
    aside = Object("aside", Box((0.04, 0.04, 0.04)), Pose((0.15, 0.25, 0.02)), At(Pose((0.15, -0.3, 0.02))))
    setup = prepare(Task("tower", (top, RED, aside)))
    found = prospects(Attempt.of(setup, setup.start, load_robot("panda").home, None))
    names = {"top", "red", "aside"}
    assert found.beyond_hope(names) == set()
    found.hopeless["red"] = found.asker.workspace.start["red"], "even alone: no grasp"
    assert found.beyond_hope(names) == {"red", "top"}
