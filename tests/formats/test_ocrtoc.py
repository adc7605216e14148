"""OCRTOC's tasks: what an import keeps, and the numbers that are known of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamp.errors import TaskError
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.scoring import score
from tamp.task import At, Mesh, Pose
from tamp.task.files.load import load_task

DATA = Path(__file__).parents[3] / "shared" / "ocrtoc"

needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="OCRTOC's data is not at ../shared/ocrtoc")

CUBE = "o cube\n" + "".join(f"v {x} {y} {z}\n" for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
CUBE += "".join(f"f {f}\n" for f in ("1 4 3 2", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8"))


def _pair(folder: Path, scene: str, target: str) -> Path:
    for name, text in (("scenes", scene), ("targets", target)):
        (folder / name).mkdir(parents=True)
        (folder / name / "1-1.yaml").write_text(text, encoding="utf-8")
    (folder / "models" / "cube").mkdir(parents=True)
    (folder / "models" / "cube" / "collision.obj").write_text(CUBE, encoding="utf-8")
    return folder


def test_instances_are_numbered_and_meshes_come_along(tmp_path: Path) -> None:
    rows = "cube:\n- [0.1, 0, 0.05, 0, 0, 1.57]\n- [0.2, 0, 0.05, 0, 0, 0]\n"
    source = _pair(tmp_path / "in", rows, rows.replace("0.1,", "0.15,"))
    imported = import_ocrtoc(source, tmp_path / "out")
    (source / "models" / "cube" / "collision.obj").unlink()
    task = load_task(imported.paths[0])
    assert [o.name for o in task.objects] == ["cube", "cube_2"]
    assert task.objects[0].pose == Pose.from_rpy((0.1, 0, 0.05), (0, 0, 1.57))
    assert task.objects[0].goal == At(Pose.from_rpy((0.15, 0, 0.05), (0, 0, 1.57)))
    assert {(o.mass, o.friction) for o in task.objects} == {(0.1, 0.5)}


@pytest.mark.parametrize(
    ("scene", "target", "said"),
    [
        ("cube:\n- [0, 0, 0, 0, 0, 0]\n", "cube: []\n", "lists other objects"),
        ("cube:\n- [0, 0, 0, 0, 0]\n", "cube:\n- [0, 0, 0, 0, 0, 0]\n", r"1-1.yaml:2: cube\[0\]: expected \[x, y, z"),
        ("cube: 3\n", "cube: 3\n", "expected a list"),
        ("ball:\n- [0, 0, 0, 0, 0, 0]\n", "ball:\n- [0, 0, 0, 0, 0, 0]\n", "there is no mesh"),
    ],
)
def test_a_pair_that_does_not_fit_is_refused(tmp_path: Path, scene: str, target: str, said: str) -> None:
    with pytest.raises(TaskError, match=said):
        import_ocrtoc(_pair(tmp_path / "in", scene, target), tmp_path / "out")


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TaskError, match="holds no tasks of OCRTOC"):
        import_ocrtoc(tmp_path, tmp_path / "out")


@needs_data
def test_the_fifty_tasks_of_2021_have_their_known_errors(tmp_path: Path) -> None:
    tasks = [load_task(path) for path in import_ocrtoc(DATA / "2021", tmp_path).paths]
    scores = [score(task, {o.name: o.pose for o in task.objects}) for task in tasks]
    assert len(tasks) == 50
    assert sum(s.ede_m or 0 for s in scores) / 50 == pytest.approx(0.314, abs=0.0005)
    assert sum(s.mean_ueb_m or 0 for s in scores) / 50 == pytest.approx(0.589, abs=0.0005)
    assert all(s.improvement in (0.0, None) for s in scores)


@needs_data
def test_the_forty_worlds_of_2020_keep_names_scales_masses_and_distractors(tmp_path: Path) -> None:
    imported = import_ocrtoc(DATA / "2020", tmp_path)
    tasks = {task.name: task for task in map(load_task, imported.paths)}
    assert len(tasks) == 40
    assert any("stands in" in warning for warning in imported.warnings)
    task = tasks["4-140"]
    cup = task.object("cup1")
    assert isinstance(cup.shape, Mesh)
    assert (cup.shape.scale, cup.mass, cup.friction) == (2.0, 0.4681873917579651, 0.5)
    assert [o.name for o in task.objects if o.goal is None] == ["toy1", "toy2", "toy3", "toy4", "toy5"]
    assert task.table.size == (0.8, 1.0)


@needs_data
def test_the_tasks_of_the_first_two_levels_of_2020_have_all_their_meshes(tmp_path: Path) -> None:
    for path in import_ocrtoc(DATA / "2020", tmp_path).paths:
        if path.name[0] in "12":
            meshes = {o.shape.path.name for o in load_task(path).objects if isinstance(o.shape, Mesh)}
            assert meshes == {"collision.obj"}, path.name
        for shape in (o.shape for o in load_task(path).objects):
            assert isinstance(shape, Mesh)
            assert shape.stand_in == (shape.path.name == "stand_in.obj")
