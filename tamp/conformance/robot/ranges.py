"""How far and how fast a robot's joints go, in words, and whether its arm gets to the table at all."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np

from tamp.task import RobotSpec, Table
from tamp.world.robot.chain import chain
from tamp.world.robot.model import RobotModel

TURNS_AT_MOST = 10  # in the range of a joint that turns
METRES_AT_MOST = 20.0  # in the range of one that slides


def widths(robot: RobotModel) -> list[str]:
    """Each joint's range in words: turns where it turns, metres where it slides."""
    return [f"{size:.2f} {unit}" for size, unit, _ in _ranges(robot)]


def too_wide(robot: RobotModel) -> str | None:
    """What is wrong with ranges that no joint has, whose limits are of another unit; None where there are none."""
    for (size, unit, most), name in zip(_ranges(robot), robot.spec.joints, strict=True):
        if size > most:
            valid = "in radians" if unit == "turns" else "in metres"
            return f"{name} has a range of {size:.2f} {unit}; limits are {valid}, and {most:g} {unit} the most"
    return None


def _ranges(robot: RobotModel) -> Iterator[tuple[float, str, float]]:
    """Each joint's range, its unit, and how much of it is believed."""
    for size, slides in zip(robot.upper - robot.lower, chain(robot).slides, strict=True):
        yield (float(size), "m", METRES_AT_MOST) if slides else (float(size) / (2 * math.pi), "turns", TURNS_AT_MOST)


def faster(spec: RobotSpec) -> Iterator[str]:
    """Which joints may go faster than the URDF says, in words."""
    joints = {joint.get("name"): joint for joint in ElementTree.fromstring(spec.description).findall("joint")}
    for name, velocity in zip(spec.joints, spec.velocity, strict=True):
        limit = joints[name].find("limit")
        given = 0.0 if limit is None else float(limit.get("velocity", "0"))
        if 0.0 < given < velocity * (1 - 1e-9):
            what, unit = ("slide", "m/s") if joints[name].get("type") == "prismatic" else ("turn", "rad/s")
            yield f"{name} may {what} at {velocity:g} {unit}, the URDF says {given:g}"


def on_table(spec: RobotSpec) -> str | None:
    """What is wrong with a base from which `arm.reach` is nowhere over the table; None where nothing is."""
    table, foot = Table(), np.array(spec.T_world_base.xyz[:2])
    half, center = np.array(table.size)[:2] / 2, np.array(table.center)[:2]
    beside = np.abs(foot - center)
    nearest, farthest = float(np.linalg.norm(np.maximum(beside - half, 0.0))), float(np.linalg.norm(beside + half))
    if nearest < spec.reach[1] and farthest > spec.reach[0]:
        return None
    near, far = spec.reach
    return (
        f"arm.reach says {near:g} to {far:g} m, but from the base the table is {nearest:.2f} to {farthest:.2f} m away: "
        f"base.xyz is in metres, and the table's middle is at x = {center[0]:g}, y = {center[1]:g}"
    )
