"""Task files: what loads, what is refused, and in which words."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tamp.errors import TaskError
from tamp.task import (
    At,
    Box,
    Capsule,
    Cylinder,
    In,
    Inertia,
    Limits,
    Object,
    On,
    Pose,
    Region,
    Sphere,
    Symmetry,
    Table,
    Task,
)
from tamp.task.files.load import load_task
from tamp.task.files.save import save_task
from tamp.task.model import ANY_TURN

BLOCK = "{name: a, shape: {box: [0.1, 0.1, 0.1]}, pose: {xyz: [0, 0, 0.05]}}"

LAUGHS = "a: &a [1,1,1,1,1,1,1,1,1]\n" + "".join(
    f"{y}: &{y} [{','.join([f'*{x}'] * 9)}]\n" for x, y in itertools.pairwise("abcdefg")
)
REFUSED = {
    "": "the file is empty",
    "- a\n": "the file is not a mapping",
    "name: x\n": ":1: objects: is missing",
    "objects: []\n": "needs at least 1 entries",
    "objects: {a: 1}\n": "must be a list",
    "objects: [a]\n": "objects[0]: 'a' is not valid; it must be a mapping with the fields name, shape",
    "objects:\n - {name: a, shape: {box: [1, 1, .nan]}, pose: {xyz: [0, 0, 0]}}": ":2: objects[0].shape.box[2]: nan",
    "objects:\n - {name: a, shape: {box: [1, 1]}, pose: {xyz: [0, 0, 0]}}": "objects[0].shape.box[2]: is missing",
    "objects:\n - {name: a, shape: {box: [1, 1, 1, 1]}, pose: {xyz: [0, 0, 0]}}": "at most 3 entries; it has 4",
    "objects:\n - {name: a, shape: {box: [1, 1, -1]}, pose: {xyz: [0, 0, 0]}}": "must be greater than 0",
    "objects:\n - {name: a, shape: {box: [1, 1, 1]}, pose: {xyz: [0, 0, 1.0e+9]}}": "too large",
    "objects:\n - {name: a, shape: {}, pose: {xyz: [0, 0, 0]}}": "exactly one of box, cylinder, sphere, capsule, mesh",
    "objects:\n - {name: a, shape: {box: [1, 1, 1]}}": "objects[0].pose: is missing",
    "objects:\n - {name: a/b, shape: {box: [1, 1, 1]}, pose: {xyz: [0, 0, 0]}}": "letters, digits",
    f"objects: [{BLOCK[:-1]}, symmetry: {{z: true}}}}]\n": "symmetry.z: True is not valid; it must be",
    f"objects: [{BLOCK[:-1]}, mass: 1.0e-12}}]\n": ":1: objects[0]: object a: mass is 1e-12; valid are positive",
    f"objects: [{BLOCK[:-1]}, inertia: {{frame: {{xyz: [0, 0, 0]}}, moments: [3, 1, 1]}}}}]\n": "no body has the",
    "objects:\n - {name: 7, shape: {box: [1, 1, 1]}, pose: {xyz: [0, 0, 0]}}": "7 is not valid; it must be text",
    "objects:\n - {name: a, shape: {box: [1, 1, 1.0e-320]}, pose: {xyz: [0, 0, 0]}}": "[0].shape: measures",
    "objects:\n - {name: a, shape: {sphere: {radius: 1.5}}, pose: {xyz: [0, 0, 0]}}": "sides are 0.0001 to 2 m long",
    f"objects: [{BLOCK}]\ntable: {{size: [1, 1], thickness: 1.0e-9}}\n": ":2: table: sides and thickness",
    f"objects: [{BLOCK}]\ncolour: red\n": ":2: colour: unknown field; valid here are name, robot",
    f"objects: [{BLOCK}]\n'[colour]': red\n": ":2: [colour]: unknown field; valid here are name, robot",
    f"objects: [{BLOCK}]\nlimits: {{planing_s: 3}}\n": "did you mean planning_s?",
    f"objects: [{BLOCK}]\nrobot: Panda\n": "unknown robot 'Panda'; did you mean 'panda'?",
    "objects: [{name: a, shape: {box: [1, 1, 1]}, pose: {xyz: [0, 0, 0], rpy: [0, 0, 90]}}]\n": "90 degrees are 1.5708",
    f"objects: [{BLOCK}]\nrobot: hal\n": "unknown robot 'hal'; installed are",
    f"objects: [{BLOCK}, {BLOCK}]\n": "objects[1].name: 'a' is taken",
    f"objects: [{BLOCK}]\nregions: [{{name: r, box: {{center: [0, 0], size: [2, 2]}}}}]\n": "beyond the table",
    f"objects: [{BLOCK}]\nsamplers: {{sample-grasp: nowhere}}\n": "package.module:function",
    "objects:\n - {name: table, shape: {box: [1, 1, 1]}, pose: {xyz: [0, 0, 0]}}": "reserved",
    "objects:\n - {name: a, shape: {box: [1, 1, 1]}, pose: {xyz: [0, 0, 0]}, goal: {on: a}}": "no possible target",
    "objects:\n - {name: a, shape: {mesh: no.obj}, pose: {xyz: [0, 0, 0]}}": "there is no file no.obj",
    "objects:\n - {name: a, shape: {mesh: /etc/hostname}, pose: {xyz: [0, 0, 0]}}": "outside the task's folder",
    "objects:\n - {name: a, shape: {mesh: ../x.obj}, pose: {xyz: [0, 0, 0]}}": "outside the task's folder",
    f"objects:\n - {{name: a, shape: {{mesh: {'x' * 5000}.obj}}, pose: {{xyz: [0, 0, 0]}}}}": "is no path",
    'objects:\n - {name: a, shape: {mesh: "a\\0.obj"}, pose: {xyz: [0, 0, 0]}}': "is no path",
    "objects:\n - {name: a, shape: {box: [1, 1, 1]}, pose: {xyz: [0, 0, 0], quat: [0, 0, 0, 0]}}": "length zero",
    '!!python/object/apply:os.system ["x"]': "is not allowed",
    f"name: {'a' * 70}\nobjects: [{BLOCK}]\n": "has 70 characters; at most 64 are valid",
    "name: a\nname: b\n": ":2: name stands twice",
    "a: [1,\n": "not YAML",
    "a: 1\n---\nb: 2\n": "a second YAML document",
    "[" * 5000: "nested deeper",
    "objects:\n" + " - {a: 1}\n" * 4_000: ":2: objects[0]",
    "\x00": "not YAML",
    "objects: &a [*a]\n": "aliases expand",
    LAUGHS: "aliases expand",
    "x" * (2 << 20): "larger than",
}  # fmt: skip


@pytest.mark.parametrize(("text", "said"), REFUSED.items(), ids=range(len(REFUSED)))
def test_a_mistake_is_named_in_one_sentence(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "task.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(TaskError) as error:
        load_task(path)
    assert said in str(error.value)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_goals_in_a_circle_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "task.yaml"
    path.write_text(
        "objects:\n"
        " - {name: a, shape: {box: [1, 1, 1]}, pose: {xyz: [0, 0, 0]}, goal: {on: b}}\n"
        " - {name: b, shape: {box: [1, 1, 1]}, pose: {xyz: [0, 0, 0]}, goal: {in: a}}\n",
        encoding="utf-8",
    )
    with pytest.raises(TaskError, match=r":3: objects\[1\]\.goal\.in: .* in a circle"):
        load_task(path)


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "none.yaml", tmp_path):
        with pytest.raises(TaskError, match="cannot be read"):
            load_task(path)


def test_the_name_of_a_file_nearby_is_offered(tmp_path: Path) -> None:
    (tmp_path / "tidy.yaml").touch()
    with pytest.raises(TaskError, match=r"there is no such file; did you mean .*tidy\.yaml\?"):
        load_task(tmp_path / "tidi.yaml")


def test_a_mesh_outside_loads_where_it_is_allowed(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("", encoding="utf-8")
    (tmp_path / "tasks").mkdir()
    path = tmp_path / "tasks" / "task.yaml"
    path.write_text("objects:\n - {name: a, shape: {mesh: ../a.obj}, pose: {xyz: [0, 0, 0]}}", encoding="utf-8")
    assert load_task(path, allow_outside=True).objects[0].shape.path == tmp_path / "a.obj"


def test_a_link_does_not_lead_a_mesh_outside(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("", encoding="utf-8")
    (tmp_path / "tasks").mkdir()
    (tmp_path / "tasks" / "a.obj").symlink_to(tmp_path / "a.obj")
    path = tmp_path / "tasks" / "task.yaml"
    path.write_text("objects:\n - {name: a, shape: {mesh: a.obj}, pose: {xyz: [0, 0, 0]}}", encoding="utf-8")
    with pytest.raises(TaskError, match="outside"):
        load_task(path)


def test_on_is_a_word_and_small_numbers_are_numbers(tmp_path: Path) -> None:
    path = tmp_path / "plain.yaml"
    path.write_text(
        "objects:\n - {name: on, shape: {box: [5e-2, 1, .5]}, pose: {xyz: [1E-3, -0, 0]}}\n"
        " - {name: yes, shape: {sphere: {radius: 1}}, pose: {xyz: [0, 0, 0]}, goal: {on: on}}\n",
        encoding="utf-8",
    )
    task = load_task(path)
    assert task.name == "plain"
    assert task.objects[0].shape == Box((0.05, 1, 0.5))
    assert task.objects[1].goal == On("on")


def test_every_field_survives_a_file(tmp_path: Path) -> None:
    pose = Pose.from_rpy((0.1, -0.2, 0.3), (0.1, 2.0, -3.0))
    task = Task(
        name="all",
        objects=(
            Object("a", Box((0.1, 0.2, 0.3)), pose, At(Pose((0, 0, 0.1)))),
            Object("b", Cylinder(0.03, 0.1), pose, On("shelf"), 0.2, 0.9),
            Object("c", Sphere(0.03), pose, In("a")),
            Object("d", Capsule(0.03, 0.1), pose, symmetry=Symmetry(x=2, z=ANY_TURN), category="can"),
            Object("e", Box((0.1, 0.1, 0.1)), pose, inertia=Inertia(pose, (1e-5, 2e-5, 3e-5))),
        ),
        regions=(Region("shelf", (0.1, 0.1), (0.1, 0.2)),),
        table=Table((0.0, 0.0), (0.8, 1.0), 0.1),
        samplers={"sample-grasp": "package.module:function"},
        limits=Limits(10.0, 20.0),
        level=3,
        path=(tmp_path / "all.yaml").resolve(),
    )
    save_task(task, tmp_path / "all.yaml")
    assert load_task(tmp_path / "all.yaml") == task


numbers = st.floats(-5, 5)
WIDE = Table((0.0, 0.0), (10.0, 10.0))


@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    xyz=st.tuples(numbers, numbers, st.floats(0, 10)), rpy=st.tuples(numbers, numbers, numbers), edge=st.floats(1e-4, 2)
)
def test_numbers_survive_a_file_to_the_last_bit(tmp_path: Path, xyz: tuple, rpy: tuple, edge: float) -> None:  # type: ignore[type-arg]
    task = Task("t", (Object("a", Box((edge, edge, edge)), Pose.from_rpy(xyz, rpy)),), table=WIDE)
    save_task(task, tmp_path / "t.yaml")
    assert load_task(tmp_path / "t.yaml").objects == task.objects


NOISE = ["", "{", "}", "[", "]", ":", ",", "-", "&a", "*a", "!", "\n", "\t", "9", "e", "'"]
VALID = f"""\
name: t
objects: [{BLOCK}, {{name: b, shape: {{cylinder: {{radius: 0.03, height: 0.1}}}}, pose: {{xyz: [0, 0.2, 0.05]}}, goal: {{on: a}}}}]
regions: [{{name: r, box: {{center: [0, 0], size: [0.1, 0.1]}}}}]
"""  # noqa: E501


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_noise_gives_a_task_or_a_task_error(tmp_path: Path, data: st.DataObject) -> None:
    text = list(VALID)
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at] = data.draw(
            st.sampled_from(["", "{", "}", "[", "]", ":", ",", "-", "&a", "*a", "!", "\n", "\t", "9", "e", "'"])
        )
    path = tmp_path / "t.yaml"
    path.write_text("".join(text), encoding="utf-8")
    try:
        load_task(path)
    except TaskError as error:
        assert "\n" not in str(error)
