"""Holding a simulator against its protocol: a world that falls, rests, touches and repeats, and a robot in it."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, cast

from tamp.conformance.checks import Check, Fault, Said, asked, judged
from tamp.conformance.findings import PartJudgement
from tamp.errors import TampError
from tamp.execution.simulator import GRAVITY, STEP, TABLE, Simulator, Touch, wait
from tamp.execution.simulators import load_simulator
from tamp.task import Box, Object, Pose, RobotSpec
from tamp.task.robot import DEFAULT_ROBOT
from tamp.task.robots import load_robot

BOX = Object("box", Box((0.05, 0.05, 0.08)), Pose((0.1, 0.2, 0.04)), mass=0.3)
OTHER = Object("other", Box((0.04, 0.04, 0.04)), Pose((0.1, -0.2, 0.02)))
HIGH = Pose((0.1, 0.2, 1.0))

SINGLE = 1e-6  # engines may count in single precision
NEAR = 0.002  # what rests, or follows, is within this of where it should be [m, rad]

ROBOT_METHODS = ("configuration", "opening", "finger_speed", "tool", "command", "open_to", "squeeze", "touching")


def check_simulator(simulator: str) -> PartJudgement:
    """Hold a simulator against `tamp.execution.simulator`: class, time, falls, rest, touches, repetition, arm and hand.

    Args:
        simulator: a built-in name, an installed one, or "package.module:Class".
    """
    return judged("simulator", simulator, _checks(simulator, load_robot(DEFAULT_ROBOT)))


def _checks(name: str, robot: RobotSpec) -> Iterator[Check]:
    yield "class", lambda: _loaded(name)
    yield "objects", lambda: _in(name, _objects)
    yield "time", lambda: _in(name, _time)
    yield "falls", lambda: _in(name, _falls)
    yield "rest", lambda: _in(name, _rests)
    yield "place", lambda: _in(name, _placed)
    yield "repetition", lambda: _repeated(name)
    yield "robot", lambda: _in(name, _robot, robot)
    yield "start", lambda: _started(name, robot)
    yield "arm", lambda: _in(name, _arm, robot)
    yield "hand", lambda: _in(name, _hand, robot)


def _loaded(name: str) -> Said:
    try:
        load_simulator(name)
    except TampError as error:
        raise Fault(str(error)) from None
    return "ok", "is made from (objects, poses, *, table, robot, q)"


def _in(name: str, check: Callable[[Any], Said], robot: RobotSpec | None = None) -> Said:
    """A check in a world of its own with two objects."""

    def tried() -> Said:
        with _made(name, (BOX, OTHER), robot=robot) as world:
            return check(world)

    return asked("", tried)


def _made(
    name: str, objects: tuple[Object, ...], poses: Mapping[str, Pose] = MappingProxyType({}), **of_robot: Any
) -> Simulator:
    """A world as its class makes it, without the guard that runs put before it."""
    options = {"table": None, "robot": None, "q": None, **of_robot}
    return cast("Simulator", load_simulator(name)(objects, poses, **options))


def _objects(world: Simulator) -> Said:
    given = {BOX.name: BOX, OTHER.name: OTHER}
    if dict(world.objects) != given:
        raise Fault(f"objects is {sorted(world.objects)}; valid is what the world was made of, box and other by name")
    if world.robot is not None:
        raise Fault("robot must be None in a world that was made without one")
    poses = world.poses()
    if odd := [pose for pose in poses.values() if not isinstance(pose, Pose)]:
        raise Fault(f"poses() has {reprlib.repr(odd[0])}; valid is a tamp.Pose of each object, T_world_object")
    if sorted(poses) != sorted(given) or any(poses[thing] != world.pose(thing) for thing in given):
        raise Fault("poses() must have what pose(name) says of every object")
    for thing, item in given.items():
        if math.dist(poses[thing].xyz, item.pose.xyz) > NEAR:
            raise Fault(f"{thing} begins at {_at(poses[thing])}; its own pose is at {_at(item.pose)}: T_world_object")
    return "ok", "begin where they are said to stand"


def _time(world: Simulator) -> Said:
    seen: list[float] = []
    world.on_step = lambda: seen.append(world.time)
    world.step()
    world.step(2)
    if not math.isclose(world.time, 3 * STEP, rel_tol=1e-6):
        raise Fault(f"time is {world.time:.6g} s after 3 steps; a step is {STEP:.6g} s")
    if len(seen) != 3:
        raise Fault(f"on_step was called {len(seen)} times in 3 steps; it is to be called after every one")
    return "ok", "240 steps a second, each told to on_step"


def _falls(world: Simulator) -> Said:
    world.place(BOX.name, HIGH)
    world.step(60)
    duration = 60 * STEP
    fallen, way = HIGH.xyz[2] - world.pose(BOX.name).xyz[2], GRAVITY * duration**2 / 2
    if abs(fallen - way) > 0.05 * way:
        raise Fault(f"an object falls {fallen:.3f} m in {duration:g} s; gravity has it fall {way:.3f} m")
    speed = world.speeds()[BOX.name][0]
    if abs(speed - GRAVITY * duration) > 0.05 * GRAVITY * duration:
        raise Fault(f"speeds() says {speed:.3f} m/s of an object that falls at {GRAVITY * duration:.3f} m/s")
    world.limit_speeds(0.1, 0.1)
    if (speed := world.speeds()[BOX.name][0]) > 0.1 + SINGLE:
        raise Fault(f"an object moves at {speed:.3f} m/s right after limit_speeds(0.1, 0.1)")
    return "ok", f"{fallen:.3f} m in {duration:g} s"


def _rests(world: Simulator) -> Said:
    world.step(240)
    off = math.dist(world.pose(BOX.name).xyz, BOX.pose.xyz)
    if off > NEAR:
        raise Fault(f"an object that stands on the table is {1000 * off:.1f} mm from there after 1 s")
    touches = [touch for touch in world.touches() if BOX.name in (touch.a, touch.b)]
    if not touches or any({touch.a, touch.b} != {BOX.name, TABLE} for touch in touches):
        said = sorted({(touch.a, touch.b) for touch in touches})
        raise Fault(f"touches() says {said} of an object that stands on the table, which is called {TABLE!r} there")
    weight, pressed = BOX.mass * GRAVITY, sum(map(_upward, touches))
    if abs(pressed - weight) > 0.1 * weight:
        raise Fault(
            f"touches() press an object of {weight:.2f} N upward with {pressed:.2f} N; `force` is in newtons, and "
            "`normal` points from b to a"
        )
    return "ok", "what stands stays, and touches carry its weight"


def _upward(touch: Touch) -> float:
    """The upward force of a touch on the box [N]."""
    return touch.force * touch.normal[2] * (1.0 if touch.a == BOX.name else -1.0)


def _placed(world: Simulator) -> Said:
    there = Pose.from_rpy((0.0, 0.1, 0.5), (0.4, 0.5, 0.6))
    world.step(10)
    other = world.pose(OTHER.name)
    world.place(BOX.name, there)
    found = world.pose(BOX.name)
    if abs(found.matrix - there.matrix).max() > SINGLE:
        raise Fault(f"place() at {_at(there)} leaves an object at {_at(found)}, or turned otherwise: T_world_object")
    if max(world.speeds()[BOX.name]) > SINGLE:
        raise Fault("an object is not at rest right after place()")
    if world.pose(OTHER.name) != other:
        raise Fault("place() moved another object")
    return "ok", "puts an object at rest, and no other"


def _repeated(name: str) -> Said:
    def run() -> dict[str, Pose]:
        with _made(name, (BOX, OTHER), {BOX.name: Pose.from_rpy((0.1, 0.2, 0.2), (0.3, 0.4, 0.5))}) as world:
            world.step(120)
            return world.poses()

    first, second = (asked("", run) for _ in range(2))
    if first != second:
        raise Fault(
            "the same world and the same steps end in other poses the second time: it must repeat to the last bit"
        )
    return "ok", "the same world repeats to the last bit"


def _robot(world: Simulator) -> Said:
    robot: Any = world.robot
    if robot is None:
        raise Fault("robot is None in a world that was made with one")
    if lacking := [name for name in ROBOT_METHODS if not callable(getattr(robot, name, None))]:
        raise Fault(f"its robot lacks {', '.join(lacking)}; tamp.execution.simulator.Robot says what they do")
    spec: RobotSpec = robot.spec
    if (off := _apart(robot.configuration(), spec.home)) > NEAR:
        raise Fault(f"the arm begins {off:.3f} rad from the robot's home")
    if _apart([robot.opening()], [spec.gripper.stroke]) > NEAR:
        raise Fault(f"the fingers begin {robot.opening():.4f} m apart; open is {spec.gripper.stroke:g} m")
    if not math.isfinite(speed := robot.finger_speed()):
        raise Fault(f"finger_speed() is {speed}; valid is the speed of the fastest finger [m/s]")
    if any(robot.touching(BOX.name)):
        raise Fault("touching() says that fingers touch an object far away")
    return "ok", f"{spec.name} begins at home with its hand open"


def _beside(robot: RobotSpec) -> tuple[float, ...]:
    """A configuration next to home."""
    return (robot.home[0] + 0.02, *robot.home[1:])


def _started(name: str, robot: RobotSpec) -> Said:
    q = _beside(robot)

    def off() -> float:
        with _made(name, (), robot=robot, q=q) as world:
            assert world.robot is not None
            return _apart(world.robot.configuration(), q)

    if (found := asked("", off)) > NEAR:
        raise Fault(f"the arm begins {found:.3f} rad from the configuration q that the world was made with")
    return "ok", "the arm begins where it is told to"


def _arm(world: Simulator) -> Said:
    robot: Any = world.robot
    there = _beside(robot.spec)
    robot.command(there)
    world.step(240)
    if (off := _apart(robot.configuration(), there)) > NEAR:
        raise Fault(f"the arm is {off:.3f} rad from what was commanded, 1 s later")
    return "ok", "follows"


def _hand(world: Simulator) -> Said:
    robot: Any = world.robot
    wide = 0.75 * robot.spec.gripper.stroke
    robot.open_to(wide)
    if not wait(world, 2.0, lambda: abs(robot.opening() - wide) < NEAR):
        raise Fault(f"the fingers are {robot.opening():.4f} m apart 2 s after open_to({wide:g})")
    robot.squeeze(robot.spec.gripper.force)
    for _ in range(240):
        world.place(OTHER.name, robot.tool())
        world.step()
    if not all(robot.touching(OTHER.name)):
        raise Fault("touching() does not say that fingers touch what is between them, 1 s after squeeze()")
    world.step(240)
    if (slid := math.dist(world.pose(OTHER.name).xyz, robot.tool().xyz)) > 0.01:
        raise Fault(f"what is squeezed slides {1000 * slid:.0f} mm out of the fingers in 1 s")
    return "ok", "opens, and holds what it squeezes by friction"


def _apart(a: Any, b: Any) -> float:
    """How far two vectors are apart in the coordinate where they differ most; infinite where one is no number."""
    if len(a) != len(b):
        raise Fault(f"the arm has {len(a)} joint positions; its robot has {len(b)} joints")
    off = [abs(float(x) - float(y)) for x, y in zip(a, b, strict=True)]
    return max(off) if all(map(math.isfinite, off)) else math.inf


def _at(pose: Pose) -> str:
    return f"({', '.join(f'{value:.3f}' for value in pose.xyz)})"
