"""What runs need is loaded and compiled before their clocks start."""

import pytest
from numba.core.dispatcher import Dispatcher

import tamp
from tamp.pipeline.loading import load_samplers
from tamp.pipeline.options.settings import Settings
from tamp.streams.affordances.tilts import tips_on
from tamp.task import At, Box, Object, Pose, Task
from tamp.world.geometry.object_geometry import geometry_of_object

BOOK = Box((0.16, 0.1, 0.02))
LYING = Object("lying", BOOK, Pose((0.0, 0.2, 0.01)), At(Pose((0.0, -0.2, 0.01))))
UPON = Object("upon", Box((0.04, 0.04, 0.06)), Pose((0.0, 0.2, 0.05)))


def test_what_is_compiled_is_compiled_before_any_limit_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    task = Task("compiled", (LYING, UPON))
    load_samplers(task, Settings())
    late: list[str] = []
    compiling = Dispatcher.compile

    def noted(self: Dispatcher, signature: object) -> object:
        late.append(f"{self.py_func.__module__}.{self.py_func.__name__} for {signature}")
        return compiling(self, signature)

    monkeypatch.setattr(Dispatcher, "compile", noted)
    tamp.plan(task)
    tips_on(geometry_of_object(UPON), Pose.from_rpy(UPON.pose.xyz, (0.3, 0.0, 0.0)), UPON.pose)
    assert not late
