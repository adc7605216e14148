"""Worlds of 2020 that are not as they should be, and what is read from those that are."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tamp.errors import TaskError
from tamp.formats.export import export_ocrtoc
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.formats.worlds import TABLE_2020
from tamp.task import At, Inertia, Mesh, Object, Pose, Symmetry, Task
from tamp.task.files.load import load_task
from tests.formats.test_ocrtoc import CUBE


@pytest.fixture
def worlds(tmp_path: Path) -> Path:
    """A folder with one task of one object."""
    mesh = tmp_path / "meshes" / "cup" / "collision.obj"
    mesh.parent.mkdir(parents=True)
    mesh.write_text(CUBE, encoding="utf-8")
    inertia = Inertia(Pose((0.01, 0, 0)), (1e-5, 2e-5, 3e-5))
    goal = At(Pose((0.1, 0, 0.1)))
    cup = Object("cup1", Mesh(mesh, 0.25), Pose(), goal, 0.3, 0.4, Symmetry(z=360), "cup", inertia)
    export_ocrtoc([Task("2-7", (cup,), table=TABLE_2020, level=2)], tmp_path / "in", 2020)
    return tmp_path / "in"


def _change(worlds: Path, old: str, new: str, name: str = "tasks/2-7/input.world") -> None:
    path = worlds / name
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('name="cup1"', 'name="../cup"', "name '../cup' is not of letters"),
        ("model://cup/coll", "model://../coll", "name '..' is not of letters"),
        ("model://cup/coll", "file://cup/coll", "expected model://NAME"),
        ("model://cup/coll", "model://pan/coll", "neither a mesh nor a size is known of the model 'pan'"),
        ("<scale>0.25 0.25 0.25", "<scale>0.25 0.25 0.5", "its scale differs between axes"),
        ("<mass>0.3", "<mass>0", "its mass is 0; expected a positive number"),
        ("<mass>0.3", "<mass>nan", "its mass is nan"),
        ("<mass>0.3</mass>", "", "has no <link/inertial/mass>"),
        ("<ixx>1e-05", "<ixx>-1", "no body has the moments of inertia \\(-1"),
        ("<mu>0.4", "<mu>0.4 0.4", "has 2 numbers; expected 1"),
        ("<mu>0.4", "<mu>rough", "could not convert"),
        ("</sdf>", "", "not XML"),
    ],
)
def test_a_world_that_cannot_be_read_is_refused_in_one_sentence(worlds: Path, old: str, new: str, said: str) -> None:
    _change(worlds, old, new)
    with pytest.raises(TaskError, match=said) as error:
        import_ocrtoc(worlds, worlds.parent / "out")
    assert "input.world" in str(error.value)
    assert "\n" not in str(error.value)


def test_an_alias_that_stands_twice_is_refused(worlds: Path) -> None:
    text = (worlds / "tasks" / "2-7" / "input.world").read_text(encoding="utf-8")
    model = text[text.index("<model") : text.index("</model>") + len("</model>")]
    _change(worlds, model, 2 * model)
    with pytest.raises(TaskError, match="model 'cup1': stands twice"):
        import_ocrtoc(worlds, worlds.parent / "out")


def test_a_target_must_know_its_objects_and_be_there(worlds: Path) -> None:
    _change(worlds, 'name="cup1"', 'name="cup2"', "tasks/2-7/target.world")
    with pytest.raises(TaskError, match="cup2 not in"):
        import_ocrtoc(worlds, worlds.parent / "out")
    (worlds / "tasks" / "2-7" / "target.world").unlink()
    with pytest.raises(TaskError, match=r"target\.world: cannot be read"):
        import_ocrtoc(worlds, worlds.parent / "out")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("symmetric_z", "symmetric_w", "the metric 'symmetric_w' is unknown"),
        ("metric", "metrik", "'metric'"),
        ("0.0,1.0", "0.0,wide", "could not convert"),
    ],
)
def test_a_table_of_objects_that_cannot_be_read_is_refused(worlds: Path, old: str, new: str, said: str) -> None:
    _change(worlds, old, new, "models/objects.csv")
    with pytest.raises(TaskError, match=f"objects.csv:2: not a row .*{said}"):
        import_ocrtoc(worlds, worlds.parent / "out")


def test_level_symmetry_category_and_inertia_are_read(worlds: Path) -> None:
    task = load_task(import_ocrtoc(worlds, worlds.parent / "out").paths[0])
    cup = task.object("cup1")
    assert (task.level, cup.symmetry, cup.category, cup.friction) == (2, Symmetry(z=360), "cup", 0.4)
    assert cup.inertia == Inertia(Pose((0.01, 0, 0)), (1e-5, 2e-5, 3e-5))


def test_products_of_inertia_are_told_about_principal_axes(worlds: Path) -> None:
    _change(worlds, "<ixy>0", "<ixy>5e-06")
    cup = load_task(import_ocrtoc(worlds, worlds.parent / "out").paths[0]).object("cup1")
    assert cup.inertia is not None
    R = cup.inertia.frame.matrix[:3, :3]
    told = R @ np.diag(cup.inertia.moments) @ R.T
    np.testing.assert_allclose(told, [[1e-5, 5e-6, 0], [5e-6, 2e-5, 0], [0, 0, 3e-5]], atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1)


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(at=st.integers(0, 2000), cut=st.integers(0, 30), noise=st.text("<>/ abz019.-e&", max_size=4))
def test_noise_gives_a_task_or_a_task_error(worlds: Path, at: int, cut: int, noise: str) -> None:
    path = worlds / "tasks" / "2-7" / "input.world"
    text = path.read_text(encoding="utf-8")
    place = len(text) // 3 + at
    path.write_text(text[:place] + noise + text[place + cut :], encoding="utf-8")
    try:
        paths = import_ocrtoc(worlds, worlds.parent / "out").paths
    except TaskError as error:
        assert "\n" not in str(error)
    else:
        assert load_task(paths[0]).name == "2-7"
    finally:
        path.write_text(text, encoding="utf-8")


def test_tasks_have_the_robot_of_their_year_where_it_stood_if_asked_for(worlds: Path, tmp_path: Path) -> None:
    (path,) = import_ocrtoc(worlds, tmp_path / "own", own_robot=True).paths
    task = load_task(path)
    assert task.robot == "ur5e_2f85" and task.base is not None
    assert task.home == (-1.57, -1.57, 1.57, 0.0, 0.0, 0.0)
    assert task.base.xyz == (-0.24, -0.005, 0.0) and task.base.rpy == pytest.approx((0.0, 0.0, -math.pi / 2))
    (path,) = import_ocrtoc(worlds, tmp_path / "usual").paths
    assert load_task(path).robot == "panda" and load_task(path).base is None
