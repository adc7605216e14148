"""The kit accepts the domain's own samplers and says of each bad one what is wrong with it."""

from __future__ import annotations

import logging
import math
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tamp
from tamp.conformance import Judgement, check_sampler
from tamp.conformance.sampler import bench, calls, kit
from tamp.conformance.sampler.bench import set_up
from tamp.domains.catalog import contract, load_domain
from tamp.domains.learned import with_model
from tamp.errors import DomainError, SamplerError
from tamp.planning import Problem
from tamp.streams.motion.paths import plan_free_motion
from tamp.streams.placing import put_aside as laid_aside
from tamp.streams.placing import regrasp as regrasps
from tamp.streams.placing.sampler import sample_placement
from tamp.streams.values import ArmPath, Grasp, Placement
from tamp.task import Pose, Task

ONE = Path(__file__).parents[2] / "scenarios" / "one_object.yaml"


@pytest.fixture(scope="module")
def one() -> Task:
    return tamp.load_task(ONE)


@pytest.fixture(scope="module")
def three() -> Task:
    return tamp.load_task(ONE.with_name("on_region.yaml"))


@pytest.fixture(scope="module")
def ringed() -> Task:
    """Where straight ways from one grasp to another are seldom free."""
    return tamp.load_task(ONE.with_name("ringed.yaml"))


def wrong(judgement: Judgement) -> str:
    return "\n".join(f"{f.check}: {f.text}" for f in judgement.findings if f.outcome == "wrong")


def notes(judgement: Judgement) -> str:
    return "\n".join(f"{f.check}: {f.text}" for f in judgement.findings if f.outcome == "note")


SCENARIOS_OF = {
    "sample-placement": "on_region",
    "sample-stacking": "mug_onto_tray",
    "sample-insertion": "in_box",
    **dict.fromkeys(("plan-laying", "sample-put-aside"), "lay_book"),
    **dict.fromkeys(("sample-laid-aside", "sample-exposed-aside"), "lay_aside"),
    **dict.fromkeys(("sample-regrasp", "regrasp-kinematics"), "regrasp_into_box"),
    "plan-detour": "slide_twice",
    "plan-sliding-to": "slide_to_goal",
    "plan-toppling": "topple_pail",
    **dict.fromkeys(("plan-sliding", "sample-exposed-grasp", "test-cfree-slide"), "slide_box"),
    "plan-nudging": "nudge_in_crate",
}
"""Scenarios that give a stream inputs, where that of one object does not."""


@pytest.mark.parametrize("stream", load_domain("tabletop").samplers)
def test_the_domains_own_samplers_fit(stream: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if "regrasp" in stream:
        # To its end it takes seconds, and the kit calls it to its end, twice.
        monkeypatch.setattr(kit, "CALLS", 1)
        monkeypatch.setattr(regrasps, "ROUNDS", 1)
    monkeypatch.setattr(kit, "ROUNDS", 1)  # of times: nothing is asked of them here
    monkeypatch.setattr(laid_aside, "TAKERS", 2)  # other streams' inputs come from there too
    monkeypatch.setattr(laid_aside, "ROUNDS", 1)
    task = tamp.load_task(ONE.with_name(f"{SCENARIOS_OF.get(stream, 'one_object')}.yaml"))
    judgement = check_sampler(load_domain("tabletop").samplers[stream], stream, tasks=[task])
    assert judgement.fits, str(judgement)
    assert judgement.numbers["calls"] > 0


def centre(height: float = 0.0, width: float = 0.05) -> Grasp:
    return Grasp(Pose.from_rpy((0.0, 0.0, height), (math.pi, 0.0, 0.0)), width)


def good(context: Any, obj: str) -> Iterator[Grasp]:
    yield centre(0.02)


def takes_too_much(context: Any, obj: str, region: str) -> Iterator[Grasp]:
    yield centre()


def returns_nothing(context: Any, obj: str) -> None:
    return None


def yields_a_pose(context: Any, obj: str) -> Iterator[Pose]:
    yield centre().T_object_tool


def raises(context: Any, obj: str) -> Iterator[Grasp]:
    raise KeyError(obj)
    yield


def gives_nothing(context: Any, obj: str) -> Iterator[Grasp]:
    context.fail(f"{obj} looks slippery")
    yield from ()


def in_millimetres(context: Any, obj: str) -> Iterator[Grasp]:
    yield centre(20.0, 50.0)


def through_the_table(context: Any, obj: str) -> Iterator[Grasp]:
    yield Grasp(Pose.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), 0.05)


class Forgetful:
    """Draws from a generator of its own."""

    def __init__(self) -> None:
        self.drawn = 0.0

    def __call__(self, context: Any, obj: str) -> Iterator[Grasp]:
        self.drawn += 0.001
        yield centre(self.drawn)


def exits(context: Any, obj: str) -> Iterator[Grasp]:
    sys.exit(0)
    yield


def fails_below(context: Any, obj: str) -> Iterator[Grasp]:
    yield centre(math.log(-1.0) if obj else 0.0)


def fails_in_ours(context: Any, obj: str) -> Iterator[Grasp]:
    yield Grasp(context.scene.task.object("nobody").pose, 0.05)


def moves_its_input(context: Any, obj: str, start: Any, grasp: Any) -> Iterator[Any]:
    object.__setattr__(start, "on", ("moon",))
    yield from ()


def leaves_a_thread(context: Any, obj: str) -> Iterator[Grasp]:
    threading.Thread(target=time.sleep, args=(20.0,), daemon=True).start()
    yield centre(0.02)


@with_model(dict)
def without_its_model(context: Any, obj: str) -> Iterator[Grasp]:
    yield centre(0.02)


BAD: dict[str, tuple[Callable[..., Any], str]] = {
    "signature": (takes_too_much, "expected a function of (context, o), found takes_too_much"),
    "model": (without_its_model, "is called with (context, model, o), the model second; this one takes (context, obj)"),
    "no generator": (returns_nothing, "expected a generator function that yields one output at a time, but the"),
    "type": (yields_a_pose, "?g must be a Grasp, found Pose"),
    "exception": (raises, "raised for ('red'): KeyError: 'red' (conformance/test_sampler.py:"),
    "end": (exits, "raised for ('red'): SystemExit: 0 (conformance/test_sampler.py:"),
    "own line": (fails_below, "ValueError: math domain error (conformance/test_sampler.py:"),
    "both lines": (fails_in_ours, ", in task/model.py:"),
    "thread": (leaves_a_thread, "left 1 thread(s) running"),
    "nothing": (gives_nothing, "nothing came from any of 1 calls; it said: red looks slippery"),
    "units": (in_millimetres, "width is 50; the gripper opens 0 to 0.08 m"),
    "randomness": (Forgetful(), "draw from context.rng only"),
    "useless": (through_the_table, "0% pass inverse-kinematics"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_is_said_in_words(name: str, one: Task) -> None:
    sampler, said = BAD[name]
    judgement = check_sampler(sampler, "sample-grasp", tasks=[one])
    assert not judgement.fits
    assert said in wrong(judgement)
    assert judgement.as_dict()["fits"] is False
    assert str(judgement).endswith("wrong")


def test_what_takes_no_model_is_refused_as_it_is_decorated() -> None:
    with pytest.raises(SamplerError, match=r"expected a function of \(context, model, \*inputs\), found .*\(context\)"):
        with_model(dict)(lambda context: iter(()))


def test_what_a_sampler_does_to_its_inputs_is_said(one: Task) -> None:
    judgement = check_sampler(moves_its_input, "inverse-kinematics", tasks=[one])
    assert "changed its input Placement(" in wrong(judgement)


def test_low_shares_downstream_come_with_reasons_and_details_with_each_call(one: Task) -> None:
    judgement = check_sampler(through_the_table, "sample-grasp", tasks=[one])
    passed = judgement.numbers["downstream"]["inverse-kinematics"]
    assert passed["share"] == 0.0
    assert passed["reasons"]
    assert f"0% pass inverse-kinematics, the domain's own 100%; it said: {passed['reasons'][0]}" in str(judgement)
    assert judgement.details[0].startswith("call 0: ('red'): 1 outputs in ")
    assert "Traceback" in check_sampler(raises, "sample-grasp", tasks=[one]).details[-1]


def test_the_domains_own_sampler_is_as_fast_as_itself(one: Task) -> None:
    """Counted, not timed: whoever is measured draws anew, and remembers nothing of others."""
    draws = {"mine": 0, "theirs": 0}
    seen: list[Any] = []

    def counted(who: str) -> Callable[..., Iterator[Grasp]]:
        def sampler(context: Any, obj: str) -> Iterator[Grasp]:
            if not any(scene is context.scene for scene in seen):  # drawn once a scene, as with a cache
                seen.append(context.scene)
                draws[who] += 1
            yield centre(0.02)

        return sampler

    entry = load_domain("tabletop")
    stream = entry.stream("sample-grasp")
    bench = set_up(entry, stream, [one], 0, 1)
    problem = bench.problem
    served = {**problem.samplers, "sample-grasp": counted("theirs")}
    bench = replace(
        bench, problem=Problem(problem.domain, problem.streams, served, problem.init, problem.goal, problem.scene)
    )
    trial = kit._Trial(stream, contract(entry, stream), counted("mine"), bench, 0)
    list(trial.errors())
    before = dict(draws)
    list(trial.time())
    assert draws["mine"] - before["mine"] == draws["theirs"] - before["theirs"] == kit.ROUNDS


def test_motions_are_measured_as_they_are_planned_not_as_they_are_remembered(three: Task) -> None:
    stream = (entry := load_domain("tabletop")).stream("plan-free-motion")
    bench = set_up(entry, stream, [three], 0, 1)
    for problem in (bench.problem, bench.with_fresh_scene(), bench.with_fresh_scene()):
        made = calls.call(problem, stream, bench.inputs[0], key="0", seed=0, outputs=1)
        assert made.outputs and problem.scene.world.motions.hits == 0


def test_a_good_sampler_fits_and_is_measured(one: Task) -> None:
    judgement = check_sampler(good, "sample-grasp", tasks=[one])
    assert judgement.fits, str(judgement)
    assert judgement.numbers["outputs"] == 1
    assert judgement.numbers["downstream"]["inverse-kinematics"]["share"] == 1.0


@pytest.mark.parametrize("stream", ["plan-free-motion", "plan-holding-motion"])
def test_motions_lead_from_one_configuration_to_another(stream: str, three: Task) -> None:
    entry = load_domain("tabletop")
    asked = set_up(entry, entry.stream(stream), [three], 0, kit.CALLS).inputs
    assert len(asked) == kit.CALLS and all(start != goal for *_, start, goal in asked)
    assert stream == "plan-free-motion" or len({obj for obj, *_ in asked}) > 1


def straight(context: Any, start: Any, goal: Any) -> Iterator[ArmPath]:
    yield ArmPath(np.array([start.q, goal.q]))


def straight_holding(context: Any, obj: str, grasp: Grasp, start: Any, goal: Any) -> Iterator[ArmPath]:
    yield from straight(context, start, goal)


def backwards(context: Any, start: Any, goal: Any) -> Iterator[ArmPath]:
    for path in plan_free_motion(context, start, goal):
        yield ArmPath(path.points[::-1])


def by_way_of_the_table(context: Any, start: Any, goal: Any) -> Iterator[ArmPath]:
    low = np.array(context.scene.world.robot.home)
    low[[1, 3]] = 1.7, -1.0
    yield ArmPath(np.array([start.q, low, goal.q]))


@pytest.mark.parametrize(
    ("sampler", "stream", "said"),
    [
        (straight, "plan-free-motion", "on the path panda_"),
        (straight_holding, "plan-holding-motion", "on the path "),
        (by_way_of_the_table, "plan-free-motion", " penetrates table ("),
        (backwards, "plan-free-motion", "rad from the configuration it was asked for"),
    ],
)
def test_paths_that_collide_or_lead_elsewhere_are_wrong(
    sampler: Callable[..., Any], stream: str, said: str, ringed: Task
) -> None:
    assert said in wrong(check_sampler(sampler, stream, tasks=[ringed]))


def test_a_sampler_that_sleeps_is_asked_once_and_the_call_is_told(
    three: Task, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def sleeps(context: Any, obj: str) -> Iterator[Grasp]:
        time.sleep(20.0)
        yield centre()

    entry = load_domain("tabletop")
    bench_of_three = set_up(entry, entry.stream("sample-grasp"), [three], 0, kit.CALLS)
    monkeypatch.setattr(kit, "set_up", lambda *_: bench_of_three)
    monkeypatch.setattr(calls, "PATIENCE_S", 0.1)
    with caplog.at_level(logging.INFO, "tamp"):
        judgement = check_sampler(sleeps, "sample-grasp")
    first = bench_of_three.inputs[0][0]
    assert wrong(judgement) == f"calls: nothing came for 0.1 s for ('{first}')"
    assert [m for m in caplog.messages if m.startswith("call")] == [f"call 1 of 3 of the sampler: ('{first}')"]


def test_a_placement_beside_its_region_is_wrong(three: Task) -> None:
    def beside(context: Any, obj: str, region: str) -> Iterator[Placement]:
        here = context.scene.start[obj]
        yield Placement(Pose((0.2, 0.3, here.pose.xyz[2]), here.pose.quat), here.on)

    assert "would stand 390 mm outside shelf" in wrong(check_sampler(beside, "sample-placement", tasks=[three]))


def test_a_grasp_in_the_worlds_frame_is_wrong(three: Task) -> None:
    def beside(context: Any, obj: str) -> Iterator[Grasp]:
        here = context.scene.start[obj].pose
        yield Grasp(here @ Pose.from_rpy((0.0, 0.0, 0.01), (math.pi, 0.0, 0.0)), 0.05)

    said = wrong(check_sampler(beside, "sample-grasp", tasks=[three]))
    assert re.search(r"the pads would close \d+ mm beside \w+: T_object_tool must be in the object's own frame", said)


def test_a_test_is_compared_with_the_domains_own(three: Task) -> None:
    never, always = (
        check_sampler(lambda context, o, p, o2, p2, said=said: said, "test-cfree-placements", tasks=[three])
        for said in (False, True)
    )
    assert "answers: never True for the 4 inputs for which the domain's own says True" in wrong(never)
    assert "answers: True for 2 of 2 inputs for which the domain's own says False, False for 0 of 4" in notes(always)
    assert always.fits


def test_outputs_that_come_again_and_calls_that_go_on_are_noted(one: Task) -> None:
    def again(context: Any, obj: str) -> Iterator[Grasp]:
        for n in range(kit.OUTPUTS + 1):
            yield centre(0.01 * (n % 2))

    said = notes(check_sampler(again, "sample-grasp", tasks=[one]))
    assert f"outputs: {kit.OUTPUTS - 2} of them repeat earlier ones of the same call" in said
    assert "end: 1 of 1 calls had not ended after 12 outputs; while a sampler goes on, no task is proven" in said


def test_nothing_is_no_mistake_where_the_domains_own_gives_nothing_either(
    one: Task, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry = load_domain("tabletop")
    made = set_up(entry, entry.stream("sample-grasp"), [one], 0, kit.CALLS)
    problem = made.problem
    samplers = {**problem.samplers, "sample-grasp": gives_nothing}
    barren = Problem(problem.domain, problem.streams, samplers, problem.init, problem.goal, problem.scene)
    monkeypatch.setattr(kit, "set_up", lambda *_: replace(made, problem=barren))
    judgement = check_sampler(gives_nothing, "sample-grasp", tasks=[one])
    assert judgement.fits and "the domain's own gives nothing there either" in notes(judgement)


def test_built_in_tasks_of_another_domain_are_passed_over(one: Task, monkeypatch: pytest.MonkeyPatch) -> None:
    tabletop, kitchen = (list(bench._default_tasks(load_domain(name))) for name in ("tabletop", "kitchen"))
    assert [task.name for task in kitchen if task not in tabletop] == ["cook_dinner"]
    monkeypatch.setattr(bench, "_default_tasks", lambda domain: [one])
    with pytest.raises(SamplerError, match=r"no built-in scenario gives inputs for sample-stacking: .* with --task"):
        check_sampler(lambda context, o, s, ps: iter(()), "sample-stacking")


def test_a_placement_in_the_air_is_noticed() -> None:
    def hovering(context: Any, obj: str, region: str) -> Iterator[Placement]:
        for placement in sample_placement(context, obj, region):
            x, y, z = placement.pose.xyz
            yield Placement(Pose((x, y, z + 0.1), placement.pose.quat), placement.on)
            return

    judgement = check_sampler(hovering, "sample-placement", tasks=[tamp.load_task(ONE.with_name("on_region.yaml"))])
    assert "would hover 101 mm" in wrong(judgement)


def test_what_does_not_exist_is_refused(one: Task) -> None:
    with pytest.raises(
        SamplerError, match=r"no stream .sample-grasps.; did you mean .sample-grasp.. tabletop has .*sample-grasp"
    ):
        check_sampler(good, "sample-grasps")
    with pytest.raises(SamplerError, match="no module 'nowhere'"):
        check_sampler("nowhere:grasps", "sample-grasp")
    with pytest.raises(DomainError, match="installed domains are"):
        check_sampler(good, "sample-grasp", domain="chess")
    with pytest.raises(SamplerError, match="no inputs for sample-stacking in one_object: nothing satisfies"):
        check_sampler(lambda context, o, s, ps: iter(()), "sample-stacking", tasks=[one])
