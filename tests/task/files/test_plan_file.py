"""Plan files: what is written reads back to the last bit; whatever else is read is refused in one sentence."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tamp.errors import PlanError
from tamp.task import Action, Attachment, Grip, Move, Plan, Pose, Release, Trajectory
from tamp.task.files.plan_file import load_plan, plan_sha256, save_plan

numbers = st.floats(-1e6, 1e6, allow_nan=False)
names = st.text(st.characters().filter(str.isprintable), min_size=1, max_size=8)
poses = st.builds(
    Pose,
    st.tuples(numbers, numbers, numbers),
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(v * v for v in q) > 0.01),
)
attachments = st.builds(Attachment, names, poses)


@st.composite
def trajectories(draw: st.DrawFn) -> Trajectory:
    n = draw(st.integers(2, 4))
    steps = draw(st.lists(st.floats(1e-3, 10), min_size=n, max_size=n))
    rows = st.lists(st.lists(numbers, min_size=7, max_size=7), min_size=n, max_size=n)
    return Trajectory(np.cumsum([0.0, *steps[1:]]), np.array(draw(rows)), np.array(draw(rows)))


moves = st.builds(
    Move,
    names,
    trajectories(),
    numbers,
    st.none() | attachments,
    st.frozensets(st.tuples(names, names), max_size=3),
    st.none() | attachments,
)
steps = moves | st.builds(Grip, attachments, numbers, st.none() | numbers) | st.builds(Release, names, poses, numbers)
actions = st.builds(Action, names, st.lists(names, max_size=3).map(tuple), st.lists(steps, max_size=3).map(tuple))
plans = st.builds(
    Plan,
    task=names,
    robot=names,
    seed=st.integers(0, 2**63),
    start=st.dictionaries(names, poses, max_size=2),
    home=st.lists(numbers, max_size=7).map(tuple),
    goals=st.dictionaries(names, poses, max_size=2),
    actions=st.lists(actions, max_size=3).map(tuple),
    report=st.dictionaries(names, st.integers() | st.booleans() | names, max_size=2),
)


def same_step(a: object, b: object) -> bool:
    if not isinstance(a, Move) or not isinstance(b, Move):
        return a == b
    arrays = ("times", "positions", "velocities")
    equal = all(np.array_equal(getattr(a.trajectory, k), getattr(b.trajectory, k)) for k in arrays)
    rest = ("phase", "opening", "held", "contacts", "pushed")
    return equal and all(getattr(a, k) == getattr(b, k) for k in rest)


@given(plan=plans)
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
def test_a_plan_survives_its_file(plan: Plan, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("plans") / "plan.json"
    save_plan(plan, path)
    read = load_plan(path)
    for field in ("task", "robot", "seed", "start", "home", "goals", "report"):
        assert getattr(read, field) == getattr(plan, field)
    assert [(a.name, a.arguments) for a in read.actions] == [(a.name, a.arguments) for a in plan.actions]
    assert all(same_step(a, b) for a, b in zip(read.steps, plan.steps, strict=True))
    assert plan_sha256(read) == plan_sha256(plan)


@pytest.fixture
def example() -> Plan:
    trajectory = Trajectory(np.array([0.0, 0.5]), np.zeros((2, 7)), np.zeros((2, 7)))
    held = Attachment("cup", Pose((0.0, 0.0, 0.01)))
    move = Move("lift", trajectory, 0.05, held, frozenset({("cup", "table"), ("robot", "cup")}))
    steps = (Grip(held, 0.05), move, Release("cup", Pose(), 0.08))
    return Plan("t", "panda", 3, {"cup": Pose()}, (0.0,) * 7, {}, (Action("pick", ("cup",), steps),), {"seconds": 1.5})


def test_the_hash_is_of_what_the_plan_does(example: Plan) -> None:
    assert plan_sha256(replace(example, report={"seconds": 99.0})) == plan_sha256(example)
    assert plan_sha256(replace(example, seed=4)) != plan_sha256(example)
    assert plan_sha256(replace(example, start={"cup": Pose((0.0, 0.0, 1e-12))})) != plan_sha256(example)


def corrupted(document: dict, path: str, value: object) -> dict:
    """The document with one value replaced; `path` is keys and indices separated by slashes."""
    *before, last = [int(key) if key.isdigit() else key for key in path.split("/")]
    node = document
    for key in before:
        node = node[key]
    node[last] = value
    return document


@pytest.mark.parametrize(
    ("path", "value", "named"),
    [
        ("format", "other", "format"),
        ("version", 2, "version"),
        ("version", True, "version"),
        ("task", "t\x1b[2J", "task must be printable"),
        ("actions/0/name", "pick\nplan.json: accepted", "actions[0].name must be printable"),
        ("start", {"cup\r": {"xyz": [0, 0, 0], "quat": [0, 0, 0, 1]}}, "start, a name in it, must be printable"),
        ("actions/0/steps/1/move/contacts", [["cup", "\x07"]], "actions[0].steps[1].move.contacts"),
        ("seed", 1.5, "seed"),
        ("seed", True, "seed"),
        ("task", None, "task"),
        ("surprise", 1, "surprise"),
        ("home", "zero", "home"),
        ("home/2", "zero", "home[2]"),
        ("home/2", 10**400, "home[2]"),
        ("start", [], "start"),
        ("start/cup/xyz", [0, 0], "start.cup"),
        ("start/cup/quat", [0, 0, 0, 0], "start.cup"),
        ("start/cup/xyz", [0, -1e200, 0], "start.cup.xyz[1] must be finite and within 1,000,000"),
        ("actions/0/steps/1/move/times", [0, 1e300], "actions[0].steps[1].move.times must be finite"),
        ("actions/0/steps/0", {"push": {}}, "actions[0].steps[0]"),
        ("actions/0/steps/0/grip/width", None, "actions[0].steps[0].grip.width"),
        ("actions/0/steps/0/grip/force", "hard", "actions[0].steps[0].grip.force must be a number"),
        ("actions/0/steps/0/grip/strength", 1, "actions[0].steps[0].grip has unknown strength; valid are object"),
        ("actions/0/steps/1/move/held", 3, "actions[0].steps[1].move.held"),
        ("actions/0/steps/1/move/contacts", [["a"]], "actions[0].steps[1].move.contacts"),
        ("actions/0/steps/1/move/times", [0, "1"], "actions[0].steps[1].move.times"),
        ("actions/0/steps/1/move/times", [0, 1, 2], "actions[0].steps[1].move"),
        ("actions/0/steps/1/move/times", [0, True], "actions[0].steps[1].move.times must be a list of numbers"),
        ("actions/0/steps/1/move/velocities", [[0] * 7, [False] + [0.0] * 6], "move.velocities must be a list of"),
        ("actions/0/steps/1/move/positions", [[0, 1], [2]], "actions[0].steps[1].move.positions"),
        ("actions/0/steps/2/release/opening", 1e999, "Infinity"),
        ("report", 7, "report"),
    ],
)
def test_a_wrong_value_is_refused_by_name(example: Plan, tmp_path: Path, path: str, value: object, named: str) -> None:
    file = tmp_path / "plan.json"
    save_plan(example, file)
    file.write_text(json.dumps(corrupted(json.loads(file.read_text()), path, value)))
    with pytest.raises(PlanError) as error:
        load_plan(file)
    assert named in str(error.value)
    assert str(file) in str(error.value)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "null",
        "[]",
        "[" * 100_000,
        '{"a":' * 50_000,
        "NaN",
        '{"format": "tamp-plan", "format": "tamp-plan"}',
        "1" * 5000,
    ],
)
def test_noise_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "plan.json"
    file.write_text(text)
    with pytest.raises(PlanError):
        load_plan(file)


def test_a_missing_or_binary_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match="cannot be read: No such file"):
        load_plan(tmp_path / "none.json")
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00{")
    with pytest.raises(PlanError, match="not UTF-8"):
        load_plan(tmp_path / "binary.json")


@given(data=st.data())
@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
def test_mutated_files_give_a_plan_or_a_plan_error(
    example: Plan, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    file = tmp_path_factory.mktemp("plans") / "plan.json"
    save_plan(example, file)
    text = bytearray(file.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(text) - 1))
        noise = data.draw(st.binary(max_size=4) | st.sampled_from([b"null", b"[", b'"', b"-"]))
        text[place : place + data.draw(st.integers(0, 5))] = noise
        if not text:
            break
    file.write_bytes(bytes(text))
    try:
        load_plan(file)
    except PlanError as error:
        assert "\n" not in str(error)
