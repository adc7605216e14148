"""Options of a run: one frozen object, recorded with each run, whose fields are keyword arguments of plan and solve."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np
import pytest

import tamp
from tamp.errors import TampError
from tamp.execution.pybullet.simulator import PyBulletSimulator
from tamp.pipeline.options.settings import MOTION_PLANNERS, Options, Settings, settings_of
from tamp.pipeline.options.tuning import DEFAULT_TUNING, Tuning
from tamp.pipeline.plan import plan
from tamp.pipeline.solving.solve import carry_out
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.workspace import HandMotion
from tamp.task import At, Box, Object, Pose, Task
from tamp.task.files.plan_file import plan_sha256

RED = Object("red", Box((0.05, 0.05, 0.08)), Pose((0.05, 0.2, 0.04)), At(Pose((0.1, -0.2, 0.04))))


class Counting(PyBulletSimulator):
    """A simulator from outside that counts its worlds, those with a robot apart."""

    with_robot = without = 0

    def __init__(self, *args, robot=None, **options):
        if robot is None:
            type(self).without += 1
        else:
            type(self).with_robot += 1
        super().__init__(*args, robot=robot, **options)


@pytest.fixture
def counting(monkeypatch):
    monkeypatch.setattr(Counting, "with_robot", 0)
    monkeypatch.setattr(Counting, "without", 0)
    return f"{__name__}:Counting"


@dataclass(frozen=True)
class Guided:
    """A strategy whose option no record can hold."""

    heuristic: Any = len
    name: ClassVar[str] = "guided"

    def __call__(self, problem: Any, settings: Any) -> Any:
        """Answer nothing."""


@pytest.mark.parametrize("field", ["simulator", "settling"])
def test_an_unknown_simulator_is_refused_at_once(field):
    with pytest.raises(TampError, match="unknown simulator 'gazebo'; valid are pybullet"):
        Settings(**{field: "gazebo"})


def test_plans_are_carried_out_in_the_simulator_asked_for_and_settled_where_they_always_are(counting):
    run = carry_out(Task("one", (RED,)), timeout=300.0, settings=Settings(simulator=counting))
    assert (Counting.with_robot, Counting.without) == (1, 0)
    assert run.result.solved
    assert run.result.simulator == run.result.settings["simulator"] == counting
    assert run.plans[0].report["settled_in"] == run.result.settings["settling"] == "pybullet"


def test_scenes_settle_where_it_is_asked_for_and_the_plan_says_so(counting):
    run = carry_out(Task("one", (RED,)), timeout=300.0, settings=Settings(settling=counting), execute=False)
    assert Counting.with_robot == 0 < Counting.without
    assert run.result.simulator == "pybullet"
    assert run.plans[0].report["settled_in"] == counting


def test_which_simulator_settled_is_no_part_of_a_plan(counting):
    task = Task("one", (RED,))
    (elsewhere,) = carry_out(task, timeout=300.0, settings=Settings(settling=counting), execute=False).plans
    assert plan_sha256(plan(task, timeout=300.0)) == plan_sha256(elsewhere)


def test_keyword_arguments_are_the_fields_of_the_settings():
    assert set(Options.__annotations__) == {f.name for f in fields(Settings)}


def test_what_is_not_said_goes_without_saying():
    assert settings_of({}) == settings_of({"domain": None, "samplers": None}) == Settings()


def test_an_unknown_option_is_refused_with_those_that_there_are():
    with pytest.raises(TypeError, match="unknown option 'stratgy'; did you mean 'strategy'"):
        tamp.plan(None, stratgy="serialized")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"strategy": "sideways"}, "unknown strategy 'sideways'; valid are all-at-once, serialized"),
        ({"strategy": "serialised"}, "unknown strategy 'serialised'; did you mean 'serialized'?"),
        ({"strategy": "nowhere.at_all:Mine"}, "strategy 'nowhere.at_all:Mine': there is no module 'nowhere'"),
        ({"strategy": "json:Mine"}, "strategy 'json:Mine': the module 'json' has no 'Mine'"),
        ({"strategy": "json:JSONDecoder"}, "strategy 'json:JSONDecoder': cannot be called; a strategy is called with"),
        ({"strategy": "datetime:date"}, "the class cannot be made without arguments: TypeError: .*; name an instance"),
        ({"strategy": "json:dumps"}, r"strategy 'json:dumps': must take \(problem, settings\): "),
        (
            {"strategy": "tests.pipeline.options.test_settings:Guided"},
            "Guided': its option heuristic is <built-in function len>, which a run's record cannot hold; valid are",
        ),
        ({"strategy": len}, "strategy is <built-in function len>; valid is its name"),
        ({"search": "json:loads"}, r"search 'json:loads': must take \(task, timeout, bound=None, effort=math.inf\): "),
        ({"search": "fff"}, "unknown search 'fff'; did you mean 'ff'.*and package.module:NAME for one of your own"),
        ({"samplers": len}, "samplers is <built-in function len>; valid is a mapping such as"),
        ({"samplers": [len]}, r"samplers is \[<built-in function len>\]; valid is a mapping"),
        ({"tuning": {"carying_speed": 0.5}}, "unknown 'carying_speed'; did you mean 'carrying_speed'"),
        ({"tuning": {"carrying_speed": 0.0}}, "carrying_speed must lie between 0 and 1, found 0.0"),
        ({"tuning": {"max_replans": 1.5}}, "max_replans must be a whole number, found 1.5"),
        ({"tuning": {"approaches_m": (0.05, 0.0)}}, "approaches_m must lie between 0 and 0.5, found"),
        ({"tuning": {"approaches_m": ()}}, "approaches_m must be one or more numbers, found"),
        ({"tuning": {"hand_margin_m": "wide"}}, "hand_margin_m must be a number, found 'wide'"),
    ],
)
def test_a_wrong_value_is_refused_in_one_sentence(given, said):
    with pytest.raises(TampError, match=said):
        settings_of(given)


def test_tuning_is_recorded_with_the_run():
    settings = Settings(tuning={"max_replans": 3})
    assert settings.tuning == Tuning(max_replans=3)
    assert settings.recorded()["tuning"]["max_replans"] == 3
    assert settings.tuning.changed() == {"max_replans": 3}
    assert DEFAULT_TUNING.changed() == {}
    recorded = json.loads(json.dumps(Settings(tuning={"approaches_m": (0.06, 0.04)}).recorded()["tuning"]))
    assert recorded["approaches_m"] == [0.06, 0.04]
    assert Settings(tuning=recorded).recorded()["tuning"] == recorded


def test_how_the_hand_comes_and_goes_reaches_the_samplers():
    assert DEFAULT_TUNING.hand == HandMotion()
    numbers = {"approaches_m": (0.06,), "withdrawals_m": 0.03, "hand_margin_m": 0.004, "push_gap_m": 0.03}
    hand = tamp.prepare(Task("one", (RED,)), tuning=numbers).hand
    assert hand == HandMotion(approaches=(0.06,), withdrawals=(0.03,), margin=0.004, push_gap=0.03)


def test_a_short_approach_is_what_is_planned():
    task = Task("one", (RED,))
    for length in (0.08, 0.04):
        workspace = tamp.prepare(task, tuning={"approaches_m": length})
        context = tamp.sampler_context(workspace)
        grasp, place = next(sample_grasp(context, "red")), workspace.start["red"]
        handling = next(inverse_kinematics(context, "red", place, grasp))[2]
        begin, end = (workspace.world.robot.forward(handling.approach[i])[:3, 3] for i in (0, -1))
        assert np.linalg.norm(end - begin) == pytest.approx(length, abs=1e-4)


def test_what_the_user_leaves_open_is_the_tasks_to_say():
    task = Task("one", (RED,), search="add", simulator="pybullet")
    settled = Settings(motion_planner="rrt").for_task(task)
    assert (settled.search, settled.motion_planner, settled.simulator) == ("add", "rrt", "pybullet")
    assert Settings(search="ff").for_task(task).search == "ff"
    assert Settings().for_task(Task("one", (RED,))).motion_planner == "portfolio"


def test_what_a_task_names_and_there_is_not_is_refused_with_file_and_line(tmp_path):
    path = tmp_path / "odd.yaml"
    path.write_text("objects: [{name: a, shape: {sphere: {radius: 0.02}}, pose: {xyz: [0, 0, 0.02]}}]\nsearch: deep\n")
    with pytest.raises(tamp.TaskError, match=r"odd.yaml:2: search: unknown search 'deep'; valid are ff, "):
        tamp.plan(tamp.load_task(path))


def test_the_motion_planners_are_those_that_the_world_has():
    from tamp.world.motion.planner import planner_names

    assert planner_names() == MOTION_PLANNERS


def test_the_searches_are_those_that_the_planner_has():
    from tamp.planning.search.fast_downward import CONFIGURATIONS

    (search,) = (f for f in fields(Settings) if f.name == "search")
    assert set(search.metadata["choices"]) == {*CONFIGURATIONS, "builtin"}
