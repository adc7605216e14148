from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tamp.execution.log import Frame
from tamp.report.rendering.camera import Camera
from tamp.report.rendering.film import render_execution
from tamp.report.rendering.scene import Stage, marks, palette, render_task
from tamp.task import At, Box, Object, On, Pose, Region, Task, load_robot

SMALL = Camera(width=160, height=90)
BOX = Object("box", Box((0.1, 0.1, 0.1)), Pose((0.1, 0.2, 0.05)), goal=At(Pose((0.1, -0.2, 0.05))))
TASK = Task("one", (BOX,), regions=(Region("right", (0.1, -0.3), (0.2, 0.2)),))


def test_an_object_is_seen_where_it_stands():
    with Stage(TASK, robot=False) as stage:
        without = stage.picture({}, camera=SMALL).astype(int)
        left = stage.picture({"box": Pose((0.1, -0.2, 0.05))}, camera=SMALL).astype(int)
        right = stage.picture({"box": Pose((0.1, 0.2, 0.05))}, camera=SMALL).astype(int)
    assert without.shape == (90, 160, 3)
    columns = [np.abs(image - without).sum(axis=2).nonzero()[1].mean() for image in (left, right)]
    assert columns[0] < 80 < columns[1]


def test_goals_are_drawn_fainter_than_objects():
    with Stage(TASK, robot=False) as stage:
        empty = stage.picture({}, camera=SMALL).astype(int)
        solid = stage.picture({"box": BOX.goal.pose}, camera=SMALL).astype(int)
        ghost = stage.picture_with_goals({}, {"box": BOX.goal.pose}, camera=SMALL).astype(int)
    assert 0 < np.abs(ghost - empty).sum() < 0.5 * np.abs(solid - empty).sum()


def test_the_robot_is_drawn_as_it_stands():
    home = load_robot("panda").home
    with Stage(TASK) as stage:
        at_home = stage.picture({}, camera=SMALL)
        turned = stage.picture({}, configuration=(1.0, *home[1:]), camera=SMALL)
        assert (stage.picture({}, camera=SMALL) == at_home).all()
    assert (at_home != turned).any()


def test_colours_differ():
    colours = palette(20)
    assert len(set(colours)) == 20
    assert all(0 <= value <= 1 for colour in colours for value in colour)


def test_pictures_are_files(tmp_path: Path):
    path = tmp_path / "folder" / "goal.png"
    render_task(TASK, {"box": BOX.pose}, path, goals=True, camera=SMALL)
    assert path.read_bytes().startswith(b"\x89PNG")


def test_an_execution_becomes_a_gif(tmp_path: Path):
    home = load_robot("panda").home
    frame = Frame(0.0, {"box": BOX.pose}, home, 0.08)
    frames = (frame, replace(frame, time=0.2, configuration=(0.3, *home[1:])))
    render_execution(TASK, frames, tmp_path / "run.gif", camera=SMALL)
    assert (tmp_path / "run.gif").read_bytes().startswith(b"GIF")
    with pytest.raises(ValueError, match="at least two frames"):
        render_execution(TASK, frames[:1], tmp_path / "run.gif")


def test_a_region_that_is_a_goal_is_marked_in_the_colour_of_what_shall_stand_there() -> None:
    shelf = Region("shelf", (0.0, 0.0), (0.3, 0.3))
    boxes = [replace(BOX, name=name, goal=On("shelf")) for name in ("first", "second")]
    task = Task("shelf", (*boxes, replace(BOX, name="third", goal=None)), regions=(shelf,))
    assert marks(task).keys() == {"first", "second"}
    for place in marks(task).values():
        assert all(abs(value) < 0.15 for value in place.xyz[:2])
    with Stage(task, robot=False) as stage:
        empty, marked = (stage.picture({}, marked=marked, camera=SMALL).astype(int) for marked in (False, True))
    assert np.abs(marked - empty).max() > 60
