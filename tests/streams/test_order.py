"""What a sampler gives depends on its inputs, the scene and the seed: not on what else was asked for before."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from functools import cache
from itertools import islice

import numpy as np
import pytest

from tamp.streams.cache import SampleCache
from tamp.streams.grasping.sampler import sample_grasp
from tamp.streams.motion.handling_contacts import handling_hits
from tamp.streams.motion.inverse_kinematics import inverse_kinematics
from tamp.streams.motion.paths import plan_free_motion, plan_holding_motion
from tamp.streams.placing.put_aside import sample_laid_aside, sample_put_aside
from tamp.streams.placing.regrasp import sample_regrasp
from tamp.streams.placing.sampler import sample_placement
from tamp.streams.pushing.grasp_after_push import sample_exposed_grasp
from tamp.streams.pushing.nudge import plan_nudging
from tamp.streams.pushing.slide import plan_sliding
from tamp.streams.pushing.topple import plan_toppling
from tamp.streams.releasing.tilted_release import plan_bringing, plan_laying
from tamp.streams.values import Configuration, Placement
from tamp.task import At, Box, Object, Pose
from tests.streams.affordances.test_topple_path import PAIL
from tests.streams.tables import CUBE, RED, ToldContext, at, panda, workspace_of

BOX = Object("box", Box((0.17, 0.11, 0.045)), Pose.from_rpy((-0.05, -0.35, 0.0225), (0.0, 0.0, 0.3)))
BLOCK = Object(
    "block",
    Box((0.04, 0.1, 0.06)),
    Pose((-0.1, 0.3, 0.03)),
    At(Pose.from_rpy((0.1, 0.35, 0.05), (np.pi / 2, 0.0, 0.0))),
)
NEXT_TO_RED = Pose((0.11, 0.2, 0.02))
AWAY = Pose((-0.25, -0.2, 0.02))
BOOK = Object("book", Box((0.04, 0.17, 0.26)), Pose((0.2, -0.35, 0.13)))
HOME = Configuration(tuple(panda().spec.home), panda().spec.gripper.stroke)
SAMPLES = 3


@cache
def table():
    return workspace_of(RED, CUBE, BOX, PAIL, BLOCK, BOOK)


def scenes(cache):
    """The same table as it is, with a cube beside others, and with little else on it; all of one run."""
    full = replace(table(), cache=cache)
    near, away = ({**full.start, "cube": Placement(pose, ("table",))} for pose in (NEXT_TO_RED, AWAY))
    near_red, cleared = replace(full, start=near), full.part({"red", "block", "book"})
    return {"full": full, "near": near_red, "away": replace(full, start=away), "cleared": cleared}


def comparable(value):
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if isinstance(value, tuple | list):
        return tuple(map(comparable, value))
    if is_dataclass(value):
        return tuple(comparable(getattr(value, field.name)) for field in fields(value))
    return value


def grasp_of(workspace, obj, seed):
    return next(sample_grasp(ToldContext(replace(workspace, cache=SampleCache()), seed=seed), obj))


@cache
def taking():
    """Red's grasp, and the arm's configurations before red is taken and after."""
    grasp = grasp_of(table(), "red", 0)
    approach, lifted, _ = next(inverse_kinematics(ToldContext(table()), "red", table().start["red"], grasp))
    return grasp, approach, lifted


def moving(context, workspace):
    _, approach, _ = taking()
    return plan_free_motion(among(context, workspace), HOME, approach)


def carrying(context, workspace):
    grasp, _, lifted = taking()
    return plan_holding_motion(among(context, workspace), "red", grasp, lifted, HOME)


def among(context, workspace):
    return replace(context, fluents=tuple(at(name, place) for name, place in workspace.start.items()))


QUERIES = [
    ("grasp", lambda c, s: sample_grasp(c, "red")),
    ("grasp of another", lambda c, s: sample_grasp(c, "block")),
    ("taking", lambda c, s: inverse_kinematics(c, "red", s.start["red"], grasp_of(table(), "red", 0))),
    ("putting", lambda c, s: inverse_kinematics(c, "red", s.goals["red"], grasp_of(table(), "red", 0))),
    ("bringing", lambda c, s: plan_bringing(c, "block", s.goals["block"], grasp_of(table(), "block", 0))),
    ("laying", lambda c, s: plan_laying(c, "block", s.goals["block"], grasp_of(table(), "block", 0))),
    ("placing", lambda c, s: sample_placement(c, "red", "table")),
    ("regrasping", lambda c, s: sample_regrasp(c, "block", s.start["block"], s.goals["block"])),
    ("putting aside", lambda c, s: sample_put_aside(c, "book", s.start["book"])),
    ("moving", moving),
    ("carrying", carrying),
    ("laying aside", lambda c, s: sample_laid_aside(c, "book", s.start["book"])),
]
NUDGED = Placement(Pose((-0.23, -0.2, 0.02)), ("table",))
PUSHES = [
    ("nudging", lambda c, s: plan_nudging(c, "cube", s.start["cube"], NUDGED)),
    ("sliding", lambda c, s: plan_sliding(c, "box", s.start["box"])),
    ("toppling", lambda c, s: plan_toppling(c, "pail", s.start["pail"])),
    ("taking after a push", lambda c, s: sample_exposed_grasp(c, "red", s.start["red"])),
]


def questions():
    for scene in ("full", "near", "away", "cleared"):
        for seed in (0, 1):
            yield from ((scene, seed, name, ask) for name, ask in QUERIES if seed == 0 or name == "grasp")
    for scene in ("full", "near", "away"):
        yield from ((scene, 0, name, ask) for name, ask in PUSHES)


def answered(cache, scene, seed, name, ask):
    workspace = scenes(cache)[scene]
    context = ToldContext(workspace, seed=seed)
    samples = list(islice(ask(context, workspace), SAMPLES))
    hits = [handling_hits(workspace, s[-1], {}) for s in samples if name in ("taking", "putting")]
    return comparable(samples), tuple(context.reasons), hits


@cache
def alone():
    """The answer to each question where nothing else was asked before."""
    return {question[:3]: answered(SampleCache(), *question) for question in questions()}


@pytest.mark.parametrize("order", range(3))
def test_samples_do_not_depend_on_what_was_asked_before(order):
    asked, cache = list(questions()), SampleCache()
    for index in np.random.default_rng(order).permutation(len(asked)):
        question = asked[index]
        assert answered(cache, *question) == alone()[question[:3]], question[:3]


def test_the_questions_are_answered_and_the_scene_and_the_seed_matter():
    answers = alone()
    for _, _, name, _ in questions():
        assert any(answers[key][0] for key in answers if key[2] == name), name
    assert answers["full", 0, "grasp"][0] != answers["full", 1, "grasp"][0]
    grasps = {name: list(sample_grasp(ToldContext(scene), "red")) for name, scene in scenes(SampleCache()).items()}
    assert grasps["full"] == grasps["away"] != grasps["near"]


def test_a_workspace_does_not_change():
    workspace = table()
    with pytest.raises(TypeError):
        workspace.start["red"] = workspace.start["cube"]
    given = dict(workspace.start)
    made = replace(workspace, start=given)
    given.clear()
    assert made.start == workspace.start
