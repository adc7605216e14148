"""The kit accepts the domain's own samplers and says of each bad one what is wrong with it."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import tamp
from tamp.conformance import Judgement, check_sampler, kit
from tamp.conformance.bench import set_up
from tamp.domains.catalog import contract, load_domain
from tamp.errors import DomainError, SamplerError
from tamp.planning import Problem
from tamp.streams.placing import put_aside as laid_aside
from tamp.streams.placing import regrasp as regrasps
from tamp.streams.placing.sampler import sample_placement
from tamp.streams.values import Grasp, Placement
from tamp.task import Pose, Task

ONE = Path(__file__).parents[2] / "scenarios" / "one_object.yaml"


@pytest.fixture(scope="module")
def one() -> Task:
    return tamp.load_task(ONE)


def wrong(judgement: Judgement) -> str:
    return "\n".join(f"{f.check}: {f.text}" for f in judgement.findings if f.outcome == "wrong")


SCENARIOS_OF = {
    "sample-placement": "on_region",
    "sample-stacking": "mug_onto_tray",
    "sample-insertion": "in_box",
    "plan-laying": "lay_book",
    "sample-put-aside": "lay_book",
    "sample-laid-aside": "lay_aside",
    "sample-regrasp": "regrasp_into_box",
    "regrasp-kinematics": "regrasp_into_box",
    "plan-sliding": "slide_box",
    "plan-detour": "slide_twice",
    "plan-toppling": "topple_pail",
    "sample-exposed-grasp": "slide_box",
    "test-cfree-slide": "slide_box",
    "plan-nudging": "nudge_in_crate",
}
"""Scenarios that give a stream inputs, where that of one object does not."""


@pytest.mark.parametrize("stream", load_domain("tabletop").samplers)
def test_the_domains_own_samplers_fit(stream: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if "regrasp" in stream:
        # To its end it takes seconds, and the kit calls it to its end, twice.
        monkeypatch.setattr(kit, "CALLS", 1)
        monkeypatch.setattr(regrasps, "ROUNDS", 1)
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


BAD: dict[str, tuple[Callable[..., Any], str]] = {
    "signature": (takes_too_much, "expected a function of (context, o), found takes_too_much"),
    "no generator": (returns_nothing, "'NoneType' object is not iterable"),
    "type": (yields_a_pose, "?g must be a Grasp, found Pose"),
    "exception": (raises, "raised for ('red'): KeyError: 'red' (conformance/test_kit.py:"),
    "end": (exits, "raised for ('red'): SystemExit: 0 (conformance/test_kit.py:"),
    "own line": (fails_below, "ValueError: math domain error (conformance/test_kit.py:"),
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


def test_a_good_sampler_fits_and_is_measured(one: Task) -> None:
    judgement = check_sampler(good, "sample-grasp", tasks=[one])
    assert judgement.fits, str(judgement)
    assert judgement.numbers["outputs"] == 1
    assert judgement.numbers["downstream"]["inverse-kinematics"]["share"] == 1.0


def test_a_placement_in_the_air_is_noticed() -> None:
    def hovering(context: Any, obj: str, region: str) -> Iterator[Placement]:
        for placement in sample_placement(context, obj, region):
            x, y, z = placement.pose.xyz
            yield Placement(Pose((x, y, z + 0.1), placement.pose.quat), placement.on)
            return

    judgement = check_sampler(hovering, "sample-placement", tasks=[tamp.load_task(ONE.with_name("on_region.yaml"))])
    assert "would hover 101 mm" in wrong(judgement)


def test_what_does_not_exist_is_refused(one: Task) -> None:
    with pytest.raises(SamplerError, match=r"no stream .sample-grasps.; tabletop has .*sample-grasp"):
        check_sampler(good, "sample-grasps")
    with pytest.raises(SamplerError, match="no module 'nowhere'"):
        check_sampler("nowhere:grasps", "sample-grasp")
    with pytest.raises(DomainError, match="installed domains are"):
        check_sampler(good, "sample-grasp", domain="chess")
    with pytest.raises(SamplerError, match="no inputs for sample-stacking in one_object: nothing satisfies"):
        check_sampler(lambda context, o, s, ps: iter(()), "sample-stacking", tasks=[one])
