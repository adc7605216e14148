"""Where a gripper's pads are in MuJoCo, against where its linkage has them: over the stroke, empty and holding blocks.

"empty": the fingers are sent to openings from closed to wide. "holding", "squeezing": they hold blocks of those widths
at home, with the force that holds light things, and with their full force. `off_mm` is the farthest that the middle of
a pad is, in the tool frame, from where kinematics have it for the width that was asked for; `sunk_mm` how much nearer
to each other the pads are than the block is wide, its contacts being soft; `linkage_mm` is `off_mm` for the opening as
it is.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from benchmarks.parts.harness import Row, main
from tamp.execution.simulator import STEP
from tamp.execution.simulators import load_simulator
from tamp.task import Box, Object, Pose, RobotSpec, load_robot
from tamp.task.robot import GENTLE_FORCE
from tamp.world.robot.linkage import linkage, pad_points

if TYPE_CHECKING:
    from tamp.execution.mujoco.simulator import MuJoCoSimulator

ASKED = "off by less than 0.5 mm"
WAIT_S = 1.5
LENGTH_M = 0.03

Held = tuple[np.ndarray, float]
"""The middles of both pads in the tool frame, (2, 3) [m], and the opening [m]."""


def rows(quick: bool, robot: str, count: int) -> Iterator[Row]:
    """A row for empty fingers, and one for each force that they hold with."""
    spec = load_robot(robot)
    widths = np.linspace(0.0, spec.gripper.stroke, 4 if quick else count)
    yield _row(spec, "empty", [(width, _empty(spec, width)) for width in widths])
    for fingers, force in (("holding", GENTLE_FORCE), ("squeezing", spec.gripper.force)):
        yield _row(spec, fingers, [(width, _holding(spec, width, force)) for width in widths[1:-1]])


def _row(spec: RobotSpec, fingers: str, held: Sequence[tuple[float, Held]]) -> Row:
    off = [_off(spec, width, pads) for width, (pads, _) in held]
    linkage_off = [_off(spec, opening, pads) for _, (pads, opening) in held]
    return {
        "fingers": fingers,
        "openings": len(held),
        "off_mm": 1e3 * max(off),
        "sunk_mm": 1e3 * max(width - opening for width, (_, opening) in held),
        "linkage_mm": 1e3 * max(linkage_off),
    }


def _off(spec: RobotSpec, opening: float, pads: np.ndarray) -> float:
    """How far the farther of the pads (2, 3) is from where the linkage has it at an opening; [m]."""
    meant = pad_points(spec, np.array([linkage(spec).driver(opening)]))[0]
    return float(np.linalg.norm(pads - meant, axis=1).max())


def _world(objects: Sequence[Object], spec: RobotSpec) -> MuJoCoSimulator:
    return cast("MuJoCoSimulator", load_simulator("mujoco")(objects, robot=spec))


def _empty(spec: RobotSpec, width: float) -> Held:
    with _world((), spec) as world:
        assert world.robot is not None
        world.robot.open_to(width)
        world.step(round(WAIT_S / STEP))
        return _pads(world), world.robot.opening()


def _holding(spec: RobotSpec, width: float, force: float) -> Held:
    """The pads as they squeeze a block; it is held in place until they do."""
    sides = [LENGTH_M] * 3
    sides[int(np.abs(spec.gripper.axis).argmax())] = float(width)
    block = Object("block", Box((sides[0], sides[1], sides[2])), Pose(), mass=0.1)
    with _world((block,), spec) as world:
        assert world.robot is not None
        middle = Pose((0.0, 0.0, float(linkage(spec).depth(width))))
        world.robot.squeeze(force)
        for _ in range(round(WAIT_S / STEP)):
            world.place(block.name, world.robot.tool() @ middle)
            world.step()
        world.step(round(WAIT_S / STEP))
        if not all(world.robot.touching(block.name)):
            raise RuntimeError(f"a block of {1e3 * width:.0f} mm was not held")
        return _pads(world), world.robot.opening()


def _pads(world: MuJoCoSimulator) -> np.ndarray:
    """The middles of both pads in the tool frame, shape (2, 3) [m]."""
    robot = world.robot
    assert robot is not None
    gripper = robot.spec.gripper
    middles = gripper.pads or ((0.0, 0.0, 0.0),) * 2
    T_tool_world = robot.tool().inverse()
    placed = [T_tool_world @ robot.link(name) @ Pose(xyz) for name, xyz in zip(gripper.fingers, middles, strict=True)]
    return np.array([pose.xyz for pose in placed])


def _options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--robot", default="ur5e_2f85", metavar="NAME", help="whose gripper; default ur5e_2f85")
    parser.add_argument("--count", type=int, default=18, metavar="N", help="openings over the stroke")
    return parser


if __name__ == "__main__":
    main("pads", lambda quick, **options: list(rows(quick, **options)), extra=_options(), asked=ASKED)
