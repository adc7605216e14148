"""Perceivers by name, and what the conformance kit says of good and bad ones."""

from __future__ import annotations

import random
import time
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tamp import clock
from tamp.errors import PartError, TampError
from tamp.perception import conformance, perceiver
from tamp.perception.conformance import LOOKS, POSES, check_perceiver
from tamp.perception.estimate import Estimate
from tamp.perception.perceiver import ask, load_perceiver
from tamp.task import Pose, Table

pytest.importorskip("embreex", reason="the extra perception is not installed")


def blind(frames: Any, objects: Mapping[str, Any], *, table: Any, seed: int) -> dict[str, Estimate]:
    return {name: Estimate(None, 0.0) for name in objects}


def knowing(frames: Any, objects: Mapping[str, Any], *, table: Any, seed: int) -> dict[str, Estimate]:
    return {name: Estimate(POSES[name], 1.0) if name in POSES else Estimate(None, 0.0) for name in objects}


def seeing_ghosts(frames: Any, objects: Mapping[str, Any], *, table: Any, seed: int) -> dict[str, Estimate]:
    return {name: Estimate(POSES.get(name, Pose()), 0.7) for name in objects}


def dicing(frames: Any, objects: Mapping[str, Any], *, table: Any, seed: int) -> dict[str, Estimate]:
    return {name: Estimate(Pose((random.random(), 0.0, 0.0)), 0.5) for name in objects}


def boasting(frames: Any, objects: Mapping[str, Any], *, table: Any, seed: int) -> dict[str, Estimate]:
    return {name: Estimate(Pose(), 2.0) for name in objects}


def forgetful(frames: Any, objects: Mapping[str, Any], *, table: Any, seed: int) -> dict[str, Estimate]:
    return {}


def bare(frames: Any, objects: Mapping[str, Any], *, table: Any, seed: int) -> Any:
    return dict.fromkeys(objects, Pose())


def listing(frames: Any, objects: Mapping[str, Any], *, table: Any, seed: int) -> Any:
    return []


def narrow(frames: Any) -> Any:
    return {}


async def waiting(frames: Any, objects: Any, *, table: Any, seed: int) -> dict[str, Estimate]:
    return {name: Estimate(None, 0.0) for name in objects}


class _Waiting:
    async def __call__(self, frames: Any, objects: Any, *, table: Any, seed: int) -> dict[str, Estimate]:
        return {name: Estimate(None, 0.0) for name in objects}


WAITS = _Waiting()


@pytest.fixture(scope="module", autouse=True)
def pictures_taken_once() -> Iterator[None]:
    """The kit's scene is rendered for the first perceiver only; none here writes into it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(conformance, "_frames", cache(conformance._frames))
        yield


@pytest.mark.parametrize("name", ["fit", f"{__name__}:blind"])
def test_perceivers_have_names(name: str) -> None:
    assert callable(load_perceiver(name))


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("eyes", "unknown perceiver 'eyes'; valid are fit and package.module:function"),
        ("eyes:", "unknown perceiver 'eyes:'; "),
        ("..eyes:f", "unknown perceiver '..eyes:f'; "),
        ("no_such_module:f", "there is no module 'no_such_module'"),
        (f"{__name__}:nothing", "has no 'nothing'"),
        (f"{__name__}:narrow", r"must take \(frames, objects, \*, table, seed\)"),
        (f"{__name__}:waiting", "is an async function; a plain one is asked for"),
        (f"{__name__}:WAITS", "is an async function; a plain one is asked for"),
        ("math:pi", "is no function"),
    ],
)
def test_what_is_no_perceiver_is_refused(name: str, said: str) -> None:
    with pytest.raises(TampError, match=said):
        load_perceiver(name)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("import torch_that_is_absent", "ModuleNotFoundError: No module named 'torch_that_is_absent'"),
        ("weights = open('/nowhere/weights')", "FileNotFoundError: .*: '/nowhere/weights'"),
    ],
)
def test_what_fails_inside_the_users_module_is_said_with_its_line(
    line: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = f"eyes_{len(line)}"
    (tmp_path / f"{name}.py").write_text(f"\n{line}\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(TampError, match=rf"^perceiver .*: {name!r} cannot be imported: {said} at .*{name}\.py:2$"):
        load_perceiver(f"{name}:see")


def raising(frames: Any, objects: Any, *, table: Any, seed: int) -> dict[str, Estimate]:
    raise KeyError("brick")


def needing(frames: Any, objects: Any, *, table: Any, seed: int) -> dict[str, Estimate]:
    frames[0]
    return {name: Estimate(None, 0.0) for name in objects}


def painting(frames: Any, objects: Any, *, table: Any, seed: int) -> dict[str, Estimate]:
    for frame in frames:
        frame.depth[:] = 0.0
    return {name: Estimate(None, 0.0) for name in objects}


def leaving(frames: Any, objects: Any, *, table: Any, seed: int) -> dict[str, Estimate]:
    raise SystemExit(3)


def diverging(frames: Any, objects: Any, *, table: Any, seed: int) -> dict[str, Estimate]:
    return {name: Estimate(Pose((float("nan"), 0.0, 0.0)), 0.5) for name in objects}


def mirroring(frames: Any, objects: Any, *, table: Any, seed: int) -> dict[str, Estimate]:
    return {name: Estimate(Pose.from_matrix(np.diag([1.0, 1.0, -1.0, 1.0])), 0.5) for name in objects}


def emptying(frames: Any, objects: Any, *, table: Any, seed: int) -> dict[str, Estimate]:
    return {name: objects.pop(name) and Estimate(None, 0.0) for name in list(objects)}


@pytest.mark.parametrize(
    ("perceiver", "said"),
    [
        (leaving, "tests.perception.test_perceiver:leaving raised SystemExit: 3 at "),
        (diverging, "tests.perception.test_perceiver:diverging: a pose needs three finite coordinates"),
        (mirroring, "is no rotation: it scales, shears or mirrors"),
        (emptying, "raised AttributeError: 'mappingproxy' object has no attribute 'pop' at "),
        (lambda *_, **__: {name: Estimate(None, 0.0, None) for name in LOOKS}, "its alternatives are a NoneType, not"),
        (dicing, "two calls with one seed differ"),
        (boasting, "its confidence 2.0 is not in 0..1"),
        (forgetful, r"names \[\]; asked for were"),
        (bare, "is a Pose, not an Estimate"),
        (listing, "is a list, not a mapping"),
        (narrow, "must take"),
        (raising, "tests.perception.test_perceiver:raising raised KeyError: 'brick' at "),
        (lambda *_, **__: {name: Estimate(np.eye(4), 1.0) for name in LOOKS}, "its pose is a ndarray, not a Pose"),
        (lambda *_, **__: {name: Estimate(None, 0.0, (np.eye(4),)) for name in LOOKS}, "alternatives is a ndarray"),
        (lambda *_, **__: {name: Estimate(Pose((0.0, 0.0, 0.1)), None) for name in LOOKS}, "is a NoneType, not a"),
        (lambda *_, **__: {name: Estimate(Pose(), np.array(0.5)) for name in LOOKS}, "confidence is a ndarray, not"),
        (lambda *_, **__: {name: Estimate(Pose((0.0, 1e200, 0.0)), 1.0) for name in LOOKS}, "is over 1000 m away; pos"),
        (needing, "raised IndexError: list index out of range at "),
        (painting, "it changed their depth; copy what is changed"),
    ],
)
def test_the_kit_says_what_is_wrong(perceiver: Any, said: str) -> None:
    wrong = [str(finding) for finding in check_perceiver(perceiver) if finding.outcome == "wrong"]
    assert len(wrong) == 1
    assert said.replace("\\", "") in wrong[0]


def test_what_a_perceiver_does_wrong_is_its_own_fault_and_none_of_the_task() -> None:
    with pytest.raises(PartError, match="raising raised KeyError: 'brick'"):
        ask(raising, [], LOOKS, table=Table(), seed=0)


def test_a_pose_that_is_none_is_said_with_the_line_that_makes_it() -> None:
    line = diverging.__code__.co_firstlineno + 1
    with pytest.raises(PartError, match=rf"^the perceiver .*:diverging: a pose needs .* at {__file__}:{line}$"):
        ask(diverging, [], LOOKS, table=Table(), seed=0)


@pytest.mark.parametrize("clock_in_use", ["wall", "processor"])
def test_one_that_hangs_is_ended_and_named(clock_in_use: clock.Clock, monkeypatch: pytest.MonkeyPatch) -> None:
    def hanging(frames: Any, objects: Mapping[str, Any], *, table: Any, seed: int) -> dict[str, Estimate]:
        while True:
            try:
                time.sleep(3600.0)
            except Exception:  # noqa: PERF203  as one that never gives up
                continue

    monkeypatch.setattr(perceiver, "PATIENCE_S", 0.02)
    said = r"perceiver tests.perception.test_perceiver:.*hanging has not answered within 0.2 s"
    with clock.limits_in(clock_in_use), pytest.raises(PartError, match=said):
        ask(hanging, (), {"red": None}, table=Table(), seed=0)  # type: ignore[dict-item]


def test_what_is_compiled_need_not_tell_what_it_takes() -> None:
    said = "the perceiver builtins:int raised TypeError"
    with pytest.raises(PartError, match=said):
        ask(load_perceiver("builtins:int"), (), {"red": None}, table=Table(), seed=0, expected={"red": Pose()})  # type: ignore[dict-item]


def test_numbers_of_other_libraries_become_pythons() -> None:
    def see(*_: Any, **__: Any) -> Any:
        return {name: Estimate(Pose(), np.float32(0.75), [Pose()]) for name in LOOKS}

    found = ask(see, [], LOOKS, table=Table(), seed=0)
    assert {(type(e.confidence), e.confidence, e.alternatives) for e in found.values()} == {(float, 0.75, (Pose(),))}


def test_the_kit_tells_other_units() -> None:
    def millimetres(frames: Any, objects: Any, *, table: Any, seed: int) -> dict[str, Estimate]:
        poses = {name: Pose(tuple(1000.0 * x for x in pose.xyz), pose.quat) for name, pose in POSES.items()}
        return {name: Estimate(poses.get(name), float(name in poses)) for name in objects}

    wrong = [f.text for f in check_perceiver(millimetres) if f.outcome == "wrong"]
    assert [text.endswith("cm off: poses are T_world_object, in metres") for text in wrong] == [True, True]


def test_the_kit_notes_what_is_missed_and_what_is_not_there() -> None:
    notes = [f.text for f in check_perceiver(blind) if f.outcome == "note"]
    assert len(notes) == 2
    assert all("was not seen" in note for note in notes)
    assert ["not there" in f.text for f in check_perceiver(seeing_ghosts) if f.outcome == "note"] == [True]
    assert {f.outcome for f in check_perceiver(knowing)} == {"ok"}


def test_the_installed_perceiver_conforms() -> None:
    assert {f.outcome for f in check_perceiver("fit")} == {"ok"}
