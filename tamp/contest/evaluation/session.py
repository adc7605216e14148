"""The server's side of the socket: each call checked, carried out in the workcell, and answered."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.contest.api.schema import ANSWERS, CALLS, VERSION, check
from tamp.contest.api.wire import Channel, Disconnected, Message, ProtocolError
from tamp.contest.evaluation.workcell import PICTURE_S, Refusal, TimeOver, Workcell
from tamp.contest.sandbox.isolation import Ending
from tamp.contest.sandbox.process import SandboxedProcess

if TYPE_CHECKING:
    from numpy.typing import NDArray

LEAVE_S = 2.0
"""How long the process may take to read the server's last word, and to end after its own [real s]."""

LAST = ("finished", "raised")
"""Calls after which there is none."""

BROKEN = (Disconnected, ProtocolError, TimeoutError)

Fields = dict[str, Any]
Arrays = dict[str, "NDArray[Any]"]
Answer = tuple[str, Fields, Arrays]

HARDLY_S = 2 * PICTURE_S
"""A call that takes less simulated time could be made so often that the time of the task ends no run [s]."""


def serve(
    channel: Channel,
    workcell: Workcell,
    process: SandboxedProcess,
    objects: Sequence[Mapping[str, Any]],
    answers_s: float,
) -> Ending:
    """Answer a solution's calls until it has finished, or is stopped.

    Args:
        channel: to the solution.
        workcell: the scene.
        process: the solution's.
        objects: of the goal, as `tamp.contest.api.schema.OBJECT` describes them.
        answers_s: see `tamp.contest.sandbox.isolation.Limits`.
    """
    left_s = answers_s

    def answer(call: Message) -> None:
        nonlocal left_s
        began, before = time.process_time(), workcell.time
        try:
            with process.waiting_for_us():
                kind, fields, arrays = _answered(workcell, call, objects)
                said = check(Message(kind, call.number, {"time_left": workcell.time_left, **fields}, arrays), ANSWERS)
        except TimeOver:
            _tell_over(channel, call.number, "the time of the task is over")
            raise
        if workcell.time - before < HARDLY_S:
            left_s -= time.process_time() - began
        if left_s < 0.0:
            process.stop(
                Ending("answers", f"pictures and refusals took the server over {answers_s:g} s of processor time")
            )
        channel.send(said, max(0.01, process.time_left))

    try:
        return _heard(channel, process, answer, "run() returned")
    except TimeOver:
        process.wait(LEAVE_S)
        return Ending("time", f"{workcell.time:g} s of simulated time are used up")


def serve_loading(channel: Channel, process: SandboxedProcess) -> Ending:
    """Listen to a solution that is only made, until it is or cannot be.

    Args:
        channel: to the solution.
        process: the solution's.
    """

    def refuse(call: Message) -> None:
        if call.kind != "hello":
            raise ProtocolError("nothing is asked before run()")

    return _heard(channel, process, refuse, "Solution() was made")


def _heard(channel: Channel, process: SandboxedProcess, answer: Callable[[Message], None], before: str) -> Ending:
    """Hear a solution's calls, of which hello is the first, until its last word or until it is not understood."""
    began = False
    try:
        while True:
            call = check(channel.receive(max(0.01, process.time_left)), CALLS)
            if call.kind in LAST:
                process.wait(LEAVE_S)
                return Ending("finished") if call.kind == "finished" else Ending("raised", call.fields["error"])
            if began == (call.kind == "hello"):
                raise ProtocolError("hello comes first, and once")
            began = True
            answer(call)
    except BROKEN as error:
        return _broken(process, error, began, before)


def _broken(process: SandboxedProcess, error: Exception, began: bool, before: str) -> Ending:
    """How a process ended that is not understood any more."""
    if isinstance(error, Disconnected):
        return _gone(process, began, before)
    if isinstance(error, ProtocolError):
        return process.stopped or Ending("protocol", str(error))
    return process.stopped or Ending("wall", "ran too long, or did not read its answers")


def _tell_over(channel: Channel, number: int, reason: str) -> None:
    try:
        channel.send(Message("over", number, {"reason": reason}), LEAVE_S)
    except (Disconnected, TimeoutError):
        return


def _gone(process: SandboxedProcess, began: bool, before: str) -> Ending:
    """Why a process closed its socket without a last word."""
    status = process.wait(LEAVE_S)
    if process.stopped is not None:
        return process.stopped
    how = "closed its socket" if status is None else f"ended with status {status}"
    number = 0 if status is None else status - 128 if status > 128 else -status
    if number in signal.valid_signals():
        how = f"was ended by signal {number} ({signal.strsignal(number)})"
    return Ending("died" if began else "start", f"the process {how} before {before}")


def _answered(workcell: Workcell, call: Message, objects: Sequence[Mapping[str, Any]]) -> Answer:
    try:
        if call.kind == "hello":
            return ("welcome", *_welcome(workcell, call, objects))
        return _CALLS[call.kind](workcell, call)
    except Refusal as refusal:
        return "refused", {"reason": str(refusal)[:1000]}, {}


def _welcome(workcell: Workcell, call: Message, objects: Sequence[Mapping[str, Any]]) -> tuple[Fields, Arrays]:
    if call.fields["version"] != VERSION:
        raise ProtocolError(f"the solution speaks version {call.fields['version']} of the API, the server {VERSION}")
    spec, table = workcell.robot.spec, workcell.task.table
    names = ("home", "lower", "upper", "velocity")
    fields = {
        "task": workcell.task.name,
        "robot": spec.name,
        "stroke": spec.gripper.stroke,
        "cameras": [{"name": name} for name in workcell.cameras],
        "joints": [{"name": name} for name in spec.joints],
        "table": [*table.center, *table.size, table.thickness],
        "objects": [dict(item) for item in objects],
    }
    return fields, {name: np.array(getattr(spec, name), dtype="<f8") for name in names}


def _state(workcell: Workcell, _: Message) -> Answer:
    q, tool, width = workcell.state()
    return "state", {"width": float(width)}, {"q": q, "T_world_tool": tool}


def _frame(workcell: Workcell, call: Message) -> Answer:
    frame = workcell.picture(call.fields["camera"]).frame
    arrays = {
        "color": frame.color,
        "depth": frame.depth.astype("<f4"),
        "robot": frame.robot.astype("u1"),
        "K": frame.intrinsics.matrix,
        "T_world_camera": frame.T_world_camera,
    }
    return "frame", {}, arrays


def _tf(workcell: Workcell, call: Message) -> Answer:
    parent, child = (workcell.frame_pose(call.fields[name]) for name in ("parent", "child"))
    return "tf", {}, {"T_parent_child": np.linalg.solve(parent, child)}


def _move_joints(workcell: Workcell, call: Message) -> Answer:
    workcell.move_joints(call.arrays["q"], call.fields["speed"])
    return "done", {}, {}


def _move_pose(workcell: Workcell, call: Message) -> Answer:
    workcell.move_pose(call.arrays["T_world_tool"], call.fields["speed"], call.fields["straight"])
    return "done", {}, {}


def _follow(workcell: Workcell, call: Message) -> Answer:
    workcell.follow(call.arrays["times"], call.arrays["positions"], call.arrays.get("velocities"))
    return "done", {}, {}


def _go_to(workcell: Workcell, call: Message) -> Answer:
    workcell.go_to(call.fields["width"], call.fields["effort"])
    return "done", {}, {}


def _wait(workcell: Workcell, call: Message) -> Answer:
    workcell.wait(call.fields["seconds"])
    return "done", {}, {}


_CALLS: Mapping[str, Callable[[Workcell, Message], Answer]] = MappingProxyType(
    {
        "state": _state,
        "frame": _frame,
        "tf": _tf,
        "move_joints": _move_joints,
        "move_pose": _move_pose,
        "follow": _follow,
        "go_to": _go_to,
        "wait": _wait,
    }
)
