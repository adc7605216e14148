"""The socket's protocol: what is sent arrives, and nothing else is believed."""

from __future__ import annotations

import errno
import pickle
import resource
import signal
import socket
import sqlite3
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from types import MappingProxyType
from urllib.error import URLError

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps

from tamp.contest.api import host, walls
from tamp.contest.api.client import Connection, Goal, Robot, TimeUp
from tamp.contest.api.schema import ANSWERS, CALLS, check
from tamp.contest.api.wire import FROM_SOLUTION, PREFIX, Channel, Disconnected, Message, ProtocolError, decode, encode

FINITE = st.floats(allow_nan=False, allow_infinity=False)
VALUES = st.recursive(st.none() | st.booleans() | st.integers() | FINITE | st.text(), lambda v: st.lists(v, max_size=3))
ARRAYS = st.sampled_from(("u1", "<f4", "<f8")).flatmap(
    lambda dtype: nps.arrays(dtype, nps.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4))
)


def _split(data: bytes) -> tuple[bytes, bytes]:
    _, header, body = PREFIX.unpack(data[: PREFIX.size])
    assert len(data) == PREFIX.size + header + body
    return data[PREFIX.size : PREFIX.size + header], data[PREFIX.size + header :]


@settings(max_examples=30)
@given(
    st.text(max_size=9),
    st.dictionaries(st.text(max_size=9), VALUES, max_size=3),
    st.dictionaries(st.text(max_size=9), ARRAYS, max_size=3),
)
def test_what_is_encoded_is_decoded(kind: str, fields: dict, arrays: dict) -> None:
    found = decode(*_split(encode(Message(kind, 7, fields, arrays))))
    assert (found.kind, found.number, found.fields) == (kind, 7, fields)
    assert found.arrays.keys() == arrays.keys()
    assert all(
        np.array_equal(found.arrays[n], a, equal_nan=True) and found.arrays[n].shape == a.shape
        for n, a in arrays.items()
    )


@given(st.binary(max_size=200), st.binary(max_size=50))
def test_any_bytes_are_a_message_or_refused(header: bytes, body: bytes) -> None:
    try:
        check(decode(header, body), CALLS)
    except ProtocolError as error:
        assert str(error)


@pytest.mark.parametrize(
    ("header", "body"),
    [
        (b'{"kind":"state","number":1,"fields":{},"arrays":[["q","f8",[2147483647,2147483647]]]}', b""),
        (b'{"kind":"state","number":1,"fields":{},"arrays":[["q","f8",[0,2147483647,2147483647]]]}', b""),
        (b'{"kind":"state","number":1,"fields":{},"arrays":[["q","f8",[-1]]]}', b""),
        (b'{"kind":"state","number":1,"fields":{},"arrays":[["q","O",[1]]]}', b"12345678"),
        (b'{"kind":"state","number":true,"fields":{},"arrays":[]}', b""),
        (b'{"kind":"state","number":1,"fields":{"x":NaN},"arrays":[]}', b""),
        (b'{"kind":"state","number":1,"fields":{},"arrays":[]}', b"left over"),
        (b"[" * 50_000, b""),
    ],
)
def test_lies_about_arrays_are_refused(header: bytes, body: bytes) -> None:
    with pytest.raises(ProtocolError):
        decode(header, body)


@pytest.mark.parametrize(
    "message",
    [
        Message("state", 1, {"extra": 1}),
        Message("wait", 1, {"seconds": 1e9}),
        Message("wait", 1, {"seconds": "1"}),
        Message("wait", 1, {"seconds": 10**400}),
        Message("frame", 1, {"camera": "x" * 1000}),
        Message("frame", 1, {"camera": "\ud800"}),
        Message("move_joints", 1, {"speed": 1.0}, {"q": np.full(7, -1e4)}),
        Message("move_pose", 1, {"speed": 1.0, "straight": True}, {"T_world_tool": np.full((4, 4), 1e9)}),
        Message("follow", 1, {}, {"times": np.array([-1e308, 1e308]), "positions": np.zeros((2, 7))}),
        Message("move_joints", 1, {"speed": 1.0}, {"q": np.full(7, np.inf)}),
        Message("move_joints", 1, {"speed": 1.0}, {"q": np.zeros((7, 1))}),
        Message("move_joints", 1, {"speed": 1.0}),
        Message("follow", 1, {}, {"times": np.zeros(10_000), "positions": np.zeros((10_000, 7))}),
        Message("teleport", 1),
    ],
)
def test_calls_of_another_form_are_refused(message: Message) -> None:
    with pytest.raises(ProtocolError):
        check(message, CALLS)


def test_a_shape_is_said_as_it_is_wanted() -> None:
    arm = {"speed": 0.5, "straight": False}
    with pytest.raises(ProtocolError, match=r"T_world_tool has shape \(3, 3\), not \(4, 4\)$"):
        check(Message("move_pose", 1, arm, {"T_world_tool": np.eye(3)}), CALLS)
    with pytest.raises(ProtocolError, match=r"q has shape \(65,\), not \(up to 64\)$"):
        check(Message("move_joints", 1, {"speed": 0.5}, {"q": np.zeros(65)}), CALLS)


def test_too_large_a_message_is_refused_before_it_is_read() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(struct.pack("!4sII", b"TC01", 2, 2**32 - 1))
        with pytest.raises(ProtocolError, match="are the most"):
            Channel(ours, FROM_SOLUTION).receive(5.0)


def test_a_message_that_trickles_in_has_one_deadline() -> None:
    ours, theirs = socket.socketpair()
    stop = threading.Event()

    def trickle() -> None:
        theirs.sendall(struct.pack("!4sII", b"TC01", 60_000, 0))
        while not stop.wait(0.01):
            theirs.send(b" ")

    thread = threading.Thread(target=trickle)
    with ours, theirs:
        thread.start()
        try:
            with pytest.raises(TimeoutError):
                Channel(ours, FROM_SOLUTION).receive(0.2)
        finally:
            stop.set()
            thread.join()


def test_a_closed_socket_is_told_apart() -> None:
    ours, theirs = socket.socketpair()
    with ours:
        theirs.close()
        with pytest.raises(Disconnected):
            Channel(ours, FROM_SOLUTION).receive(1.0)


def test_every_question_has_an_answer() -> None:
    assert set(ANSWERS) == {"welcome", "state", "frame", "tf", "done", "refused", "over"}


def test_the_client_needs_numpy_only() -> None:
    code = "import sys, tamp.contest.api.host; print(*{name.partition('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"pybullet", "mujoco", "pinocchio", "pydantic", "yaml", "scipy", "ompl"} & set(done.stdout.split())


@pytest.mark.parametrize(
    ("call", "complaint"),
    [
        (lambda robot: robot.wait(None), "seconds is None, expected a number"),
        (lambda robot: robot.wait(10**400), "seconds is 1000.*, expected a number"),
        (lambda robot: robot.arm.move_joints([0.0], speed="fast"), "speed is 'fast', expected a number"),
        (lambda robot: robot.arm.move_joints("home"), "q is 'home', expected an array of numbers"),
        (
            lambda robot: robot.arm.move_pose([[1.0, 0.0], [0.0]]),
            r"T_world_tool is \[\[1.0, 0.0\], .*, expected an array",
        ),
        (lambda robot: robot.arm.follow([0.0, 1.0], [0.0, 1.0]), r"positions has shape \(2,\), expected 2 dimensions"),
        (lambda robot: robot.gripper.go_to([]), r"width is \[\], expected a number"),
        (lambda robot: robot.camera.frame(None), "camera is not text"),
    ],
)
def test_what_is_no_argument_is_named_and_nothing_is_sent(call: Callable[[Robot], object], complaint: str) -> None:
    joints = [{"name": "one"}]
    fields = {"robot": "panda", "stroke": 0.08, "cameras": [{"name": "kinect"}], "joints": joints}
    names = ("home", "lower", "upper", "velocity")
    welcome = Message("welcome", 1, fields, {name: np.zeros(1) for name in names})
    ours, theirs = socket.socketpair()
    with ours, theirs:
        with pytest.raises(ValueError, match=complaint):
            call(Robot(Connection(Channel(ours, FROM_SOLUTION)), welcome))
        theirs.setblocking(False)
        with pytest.raises(BlockingIOError):
            theirs.recv(1)


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (URLError(socket.gaierror(-3, "no resolution")), "the sandbox has no network"),
        (PermissionError(errno.EPERM, "not permitted"), "the sandbox has no network"),
        (sqlite3.OperationalError("access permission denied"), "for SQLite, nolock=1"),
        (OSError(errno.EROFS, "read-only"), "only /tmp can be written to"),
        (MemoryError("Unable to allocate 9 GiB"), "limited by 'memory_mb'"),
        (OSError(errno.ENOSPC, "no space"), "limited by 'scratch_mb'"),
        (FileNotFoundError(errno.ENOENT, "no such file"), ""),
        (ValueError("of its own"), ""),
    ],
)
def test_what_of_the_sandbox_is_behind_an_exception_is_said(error: Exception, said: str) -> None:
    assert said in walls.met(error) and bool(said) == bool(walls.met(error))
    outer = RuntimeError("cannot be done")
    outer.__cause__ = error
    assert walls.met(outer) == walls.met(error)


def _answering(theirs: socket.socket) -> None:
    """Answer each call by its number, in two pieces, until there is none any more."""
    channel = Channel(theirs, FROM_SOLUTION)
    with suppress(Disconnected):
        while True:
            call = channel.receive()
            data = encode(Message("tf", call.number, {"time_left": 1.0}, {"T_parent_child": np.eye(4)}))
            for piece in (data[:20], data[20:]):
                theirs.sendall(piece)
                time.sleep(0.002)


@pytest.fixture
def asked() -> Iterator[Connection]:
    ours, theirs = socket.socketpair()
    thread = threading.Thread(target=_answering, args=(theirs,))
    thread.start()
    with ours, theirs:
        yield Connection(Channel(ours, FROM_SOLUTION))
        ours.shutdown(socket.SHUT_RDWR)
        thread.join()


FRAMES = {"parent": "world", "child": "tool"}


def test_several_threads_may_ask(asked: Connection) -> None:
    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(lambda _: asked.ask("tf", FRAMES).number, range(20)))
    assert sorted(answers) == list(range(1, 21))


def test_when_the_time_is_over_none_is_left() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(encode(Message("over", 1, {"reason": "the time of the task is over"})))
        connection = Connection(Channel(ours, FROM_SOLUTION))
        connection.time_left = 3.0
        with pytest.raises(TimeUp, match="the time of the task is over"):
            connection.ask("wait", {"seconds": 5.0})
        assert connection.time_left == 0.0


def test_an_alarm_of_the_solutions_own_leaves_no_half_answer(asked: Connection) -> None:
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        for after_s in (0.001, 0.002, 0.003):
            with suppress(KeyboardInterrupt):
                signal.setitimer(signal.ITIMER_REAL, after_s)
                asked.ask("tf", FRAMES)
                time.sleep(1.0)
            assert asked.ask("tf", FRAMES).kind == "tf"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_a_robot_is_asked_in_one_process_and_a_goal_goes_anywhere(asked: Connection) -> None:
    with pytest.raises(TypeError, match="the process that run"):
        pickle.dumps(asked)
    asked._process += 1
    with pytest.raises(RuntimeError, match="send what was seen to others"):
        asked.ask("tf", FRAMES)
    with pytest.raises(RuntimeError, match="send what was seen to others"):
        asked.tell("finished")
    goal = Goal("task", MappingProxyType({}), (0.0,))
    assert pickle.loads(pickle.dumps(goal)).objects == goal.objects


def test_limits_are_no_higher_than_the_machine_allows(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = {}
    monkeypatch.setattr(resource, "setrlimit", lambda kind, limits: taken.update({kind: limits}))
    for kind, highest in ((0, 100), (1, 200), (2, resource.RLIM_INFINITY)):
        monkeypatch.setattr(resource, "getrlimit", lambda _, highest=highest: (50, highest))
        host.limit(kind, 150)
    assert taken == {0: (100, 100), 1: (150, 150), 2: (150, 150)}
