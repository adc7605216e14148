"""Out and in again: nothing that a form has a place for is lost, and what it has none for is said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tamp.cli import main
from tamp.errors import TaskError
from tamp.formats.export import Year, export_ocrtoc
from tamp.formats.ocrtoc import import_ocrtoc
from tamp.formats.pairs import MASS_2021
from tamp.formats.worlds import TABLE_2020
from tamp.task import At, Box, Inertia, Mesh, Object, On, Pose, Region, Symmetry, Task
from tamp.task.files.load import load_task
from tamp.task.files.save import save_task
from tamp.task.files.yaml_document import read_document
from tests.formats.test_ocrtoc import CUBE, DATA, needs_data

MESHES = ("cup", "cup_2", "box")
MARKS = (Symmetry(), Symmetry(z=360), Symmetry(x=2), Symmetry(y=4))

coordinate = st.floats(-1, 1)
angle = st.floats(-3.14, 3.14)
poses = st.builds(
    Pose.from_rpy, st.tuples(coordinate, coordinate, coordinate), st.tuples(angle, st.floats(-1.57, 1.57), angle)
)
positive = st.floats(1e-4, 2)


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Mesh]:
    folder = tmp_path_factory.mktemp("meshes")
    found = {}
    for i, name in enumerate(MESHES):
        path = folder / name / "collision.obj"
        path.parent.mkdir()
        path.write_text(CUBE.replace("v 1", f"v 1.{i}"), encoding="utf-8")
        found[name] = Mesh(path, 0.1)
    return found


def _plain(task: Task) -> Task:
    """With the meshes' contents in place of where they lie."""
    objects = tuple(
        replace(o, shape=(o.shape.path.name, o.shape.path.read_bytes(), o.shape.scale))  # type: ignore[arg-type, union-attr]
        for o in task.objects
    )
    return replace(task, objects=objects, path=None)


def _there_and_back(tasks: list[Task], folder: Path, year: Year) -> tuple[list[Task], tuple[str, ...]]:
    exported = export_ocrtoc(tasks, folder / "out", year)
    assert len(exported.paths) == len(tasks)
    imported = import_ocrtoc(folder / "out", folder / "in")
    return [load_task(path) for path in imported.paths], exported.warnings


def _assert_same(there: Task, back: Task) -> None:
    """Equal, orientations to 1e-12: roll, pitch and yaw cannot say every quaternion to the last bit."""
    assert [o.name for o in there.objects] == [o.name for o in back.objects]
    for a, b in zip(_plain(there).objects, _plain(back).objects, strict=True):
        assert _close(a.pose, b.pose)
        assert (a.goal is None) is (b.goal is None)
        if isinstance(a.goal, At) and isinstance(b.goal, At):
            assert _close(a.goal.pose, b.goal.pose)
        if a.inertia and b.inertia:
            assert _close(a.inertia.frame, b.inertia.frame)
            assert a.inertia.moments == b.inertia.moments
        same: dict[str, Any] = {"pose": b.pose, "goal": b.goal, "inertia": a.inertia and b.inertia}
        assert replace(a, **same) == b
    assert replace(_plain(there), objects=()) == replace(_plain(back), objects=())


def _close(a: Pose, b: Pose) -> bool:
    return bool(np.abs(a.matrix - b.matrix).max() < 1e-12)


def _at_size(mesh: Mesh, folder: Path) -> Mesh:
    """The mesh with its scale worked in, as 2021 wants it."""
    path = folder / mesh.path.parent.name / "collision.obj"
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [
        " ".join(["v", *(repr(0.1 * float(x)) for x in line.split()[1:])]) if line.startswith("v ") else line
        for line in mesh.path.read_text(encoding="utf-8").splitlines()
    ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return Mesh(path)


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(data=st.data())
def test_what_2021_has_a_place_for_comes_back(
    data: st.DataObject, meshes: dict[str, Mesh], tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("pairs")
    models = data.draw(st.lists(st.sampled_from(MESHES), min_size=1, unique=True))
    marks = {model: data.draw(st.sampled_from([*MARKS, Symmetry(2, 3, 360)])) for model in models}
    objects = []
    for model in models:
        for number in range(1, 1 + data.draw(st.integers(1, 3))):
            name = model if number == 1 else f"{model}_{number}"
            name = f"{name}_instance" if number > 1 and name in models else name
            shape = _at_size(meshes[model], folder)
            goal = At(data.draw(poses))
            objects.append(Object(name, shape, data.draw(poses), goal, symmetry=marks[model]))
    task = Task("t", tuple(objects))
    (back,), warnings = _there_and_back([task], folder, 2021)
    assert warnings == ()
    _assert_same(task, back)


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(data=st.data())
def test_what_2020_has_a_place_for_comes_back(
    data: st.DataObject, meshes: dict[str, Mesh], tmp_path_factory: pytest.TempPathFactory
) -> None:
    marks = {model: data.draw(st.sampled_from(MARKS)) for model in MESHES}
    kinds = {model: data.draw(st.sampled_from([None, "cup", "hardware_tools"])) for model in MESHES}
    halves = st.tuples(positive, positive, positive)  # of each moment: what two of them share is the third's
    inertias = st.builds(Inertia, poses, halves.map(lambda h: (h[1] + h[2], h[0] + h[2], h[0] + h[1])))

    def thing(number: int) -> Object:
        model = data.draw(st.sampled_from(MESHES))
        return Object(
            name=f"alias{number}",
            shape=replace(meshes[model], scale=data.draw(st.sampled_from([0.1, 0.25, 1.0]))),
            pose=data.draw(poses),
            goal=data.draw(st.none() | st.builds(At, poses)),
            mass=data.draw(positive),
            friction=data.draw(positive),
            symmetry=marks[model],
            category=kinds[model],
            inertia=data.draw(st.none() | inertias),
        )

    task = Task("3-14", tuple(map(thing, range(data.draw(st.integers(1, 4))))), table=TABLE_2020, level=3)
    (back,), warnings = _there_and_back([task], tmp_path_factory.mktemp("worlds"), 2020)
    assert warnings == ()
    _assert_same(task, back)


@needs_data
def test_the_fifty_pairs_of_2021_come_back_number_for_number(tmp_path: Path) -> None:
    tasks = [load_task(path) for path in import_ocrtoc(DATA / "2021", tmp_path / "first").paths]
    back, warnings = _there_and_back(tasks, tmp_path, 2021)
    assert warnings == ()
    assert [_plain(t) for t in back] == [_plain(t) for t in tasks]
    originals = [*(DATA / "2021" / "scenes").glob("*.yaml"), *(DATA / "2021" / "targets").glob("*.yaml")]
    assert len(originals) == 100
    for path in originals:
        assert read_document(tmp_path / "out" / path.parent.name / path.name).value == read_document(path).value


@needs_data
def test_the_forty_worlds_of_2020_come_back_element_for_element(tmp_path: Path) -> None:
    """And with the same stand-ins for the meshes that are not there."""
    first = import_ocrtoc(DATA / "2020", tmp_path / "first")
    tasks = [load_task(path) for path in first.paths]
    assert export_ocrtoc(tasks, tmp_path / "out", 2020).warnings == ()
    second = import_ocrtoc(tmp_path / "out", tmp_path / "in")
    assert second.warnings == first.warnings != ()
    back = [load_task(path) for path in second.paths]
    for there, again in zip(tasks, back, strict=True):
        _assert_same(there, again)
    originals = sorted((DATA / "2020" / "tasks").glob("*/*.world"))
    assert len(originals) == 80
    for path in originals:
        written = tmp_path / "out" / "tasks" / path.parent.name / path.name
        _assert_like(ElementTree.parse(written).getroot(), ElementTree.parse(path).getroot(), str(path))


def _assert_like(a: ElementTree.Element, b: ElementTree.Element, where: str) -> None:
    """The same elements, attributes and text; numbers by their value, poses by where they put things."""
    where = f"{where} {b.tag} {b.get('name', '')}"
    assert (a.tag, a.attrib, len(a)) == (b.tag, b.attrib, len(b)), where
    texts = (a.text or "").split(), (b.text or "").split()
    if a.tag == "pose":
        assert _close(*(Pose.from_rpy(tuple(map(float, t[:3])), tuple(map(float, t[3:]))) for t in texts)), where  # type: ignore[arg-type]
    elif texts[1] and texts[1][0].lstrip("-")[:1].isdigit():
        assert [list(map(float, t)) for t in texts[:1]] == [list(map(float, t)) for t in texts[1:]], where
    else:
        assert texts[0] == texts[1], where
    for one, other in zip(a, b, strict=True):
        _assert_like(one, other, where)


BLOCK = Object("red", Box((0.04, 0.05, 0.06)), Pose((0, 0, 0.03)), At(Pose((0.1, 0, 0.03))), mass=0.2)


@pytest.mark.parametrize("year", [2020, 2021])
def test_what_a_form_has_no_place_for_is_said(tmp_path: Path, year: Year) -> None:
    task = Task("t", (BLOCK,), regions=(Region("r", (0, 0), (0.1, 0.1)),), level=2)
    (back,), warnings = _there_and_back([task], tmp_path, year)
    assert len(warnings) == 1
    assert "regions, level" in warnings[0].replace("table, ", "")
    assert ("mass" in warnings[0]) is (year == 2021)
    assert back.object("red").mass == (0.2 if year == 2020 else MASS_2021)
    assert back.object("red").pose == BLOCK.pose


def test_names_of_ones_own_are_kept_by_models_of_their_own(tmp_path: Path, meshes: dict[str, Mesh]) -> None:
    cup = _at_size(meshes["cup"], tmp_path / "made")
    names = ("left", "right")
    task = Task("t", tuple(Object(n, cup, Pose(), At(Pose())) for n in names))
    (back,), warnings = _there_and_back([task], tmp_path, 2021)
    assert tuple(o.name for o in back.objects) == names
    assert "a model of its own" in warnings[0]


def test_a_scale_is_worked_into_the_mesh_of_2021(tmp_path: Path, meshes: dict[str, Mesh]) -> None:
    from tamp.task.mesh.parts import bounds

    task = Task("t", (Object("cup", meshes["cup"], Pose(), At(Pose())),))
    (back,), warnings = _there_and_back([task], tmp_path, 2021)
    assert "scales" in warnings[0]
    np.testing.assert_allclose(bounds(back.objects[0].shape), bounds(meshes["cup"]))


@pytest.mark.parametrize(
    ("things", "year", "said"),
    [
        ((replace(BLOCK, goal=On("r")),), 2020, "the goal of red is no pose"),
        ((replace(BLOCK, goal=None),), 2021, "red has no goal"),
    ],
)
def test_what_cannot_be_said_is_refused(tmp_path: Path, things: tuple[Object, ...], year: Year, said: str) -> None:
    with pytest.raises(TaskError, match=said):
        export_ocrtoc([Task("t", things, regions=(Region("r", (0, 0), (0.1, 0.1)),))], tmp_path, year)


def test_two_models_of_one_name_are_refused(tmp_path: Path) -> None:
    tasks = [Task(name, (replace(BLOCK, shape=Box(size)),)) for name, size in (("a", (1, 1, 1)), ("b", (1, 1, 2)))]
    with pytest.raises(TaskError, match="two models called red differ"):
        export_ocrtoc(tasks, tmp_path, 2021)


def test_the_command_writes_what_import_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save_task(Task("one", (replace(BLOCK, mass=MASS_2021),)), tmp_path / "one.yaml")
    out = tmp_path / "out"
    assert main(["export", "ocrtoc", str(tmp_path / "one.yaml"), "-o", str(out), "--year", "2021"]) == 0
    said = capsys.readouterr()
    assert "1 task in" in said.out
    assert "tamp: warning: task one: the files of 2021 have no place for the exact form" in said.err
    assert main(["import", "ocrtoc", str(out), "-o", str(tmp_path / "back")]) == 0
    assert load_task(tmp_path / "back" / "one.yaml").object("red").pose == BLOCK.pose
