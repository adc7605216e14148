"""A scripted solution of about fifty lines: looks once, and carries what stands alone straight to its goal.

It finds objects as bumps on the table in the fixed camera's depth picture, takes the bump for the object whose height
fits best, grasps it from above at its middle, and sets it down where the goal has it. It never turns anything.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.contest.api.client import Refused

if TYPE_CHECKING:
    from tamp.contest.api.client import Frame, Goal, Robot

DOWN = np.diag([1.0, -1.0, -1.0, 1.0])
"""The tool pointing down: z of the tool is the approach direction."""
CELL, LOW, ABOVE = 0.02, 0.015, 0.12


class Solution:
    """Pick and place from above."""

    def run(self, goal: Goal, robot: Robot) -> None:
        """Carry each object that has a goal pose."""
        bumps = find_bumps(robot.camera.frame(robot.camera.names[0]), goal.table)
        for name, thing in goal.objects.items():
            if thing.pose is None or not bumps:
                continue
            points = np.array([line.split()[1:4] for line in thing.mesh.read_text().splitlines() if line[:2] == "v "])
            size = np.ptp(points.astype(float), axis=0)
            bump = min(bumps, key=lambda b: abs(b[2] - size[2]) + 2 * abs(b[3] - float(size[:2].max())))
            x, y, height, _ = bump
            try:
                carry(robot, (x, y, height / 2), thing.pose[:3, 3] + (0, 0, height / 2 - size[2] / 2 + 0.002))
                bumps.remove(bump)
            except Refused as refused:
                print(f"{name}: {refused}")
                robot.gripper.go_to(robot.gripper.stroke)


def find_bumps(frame: Frame, table: tuple[float, ...]) -> list[tuple[float, float, float, float]]:
    """Connected cells of the table on which something stands: x, y, height, width [m]."""
    v, u = np.nonzero((frame.depth > 0) & ~frame.robot)
    rays = np.linalg.solve(frame.K, np.array([u + 0.5, v + 0.5, np.ones(len(u))]))
    points = (frame.T_world_camera[:3, :3] @ (rays * frame.depth[v, u])).T + frame.T_world_camera[:3, 3]
    near = (np.abs(points[:, :2] - table[:2]) < np.array(table[2:4]) / 2 - CELL).all(axis=1) & (points[:, 2] > LOW)
    cells: dict[tuple[int, int], list[Any]] = {}
    for point in points[near & (points[:, 2] < 0.4)]:
        cells.setdefault((int(point[0] // CELL), int(point[1] // CELL)), []).append(point)
    bumps, left = [], {cell for cell, found in cells.items() if len(found) > 5}
    while left:
        group = [left.pop()]
        for i, j in group:
            beside = {(i + a, j + b) for a in (-1, 0, 1) for b in (-1, 0, 1)} & left
            group += sorted(beside)
            left -= beside
        low, high = (
            f([p for cell in group for p in cells[cell]], q, axis=0)
            for f, q in ((np.percentile, 2), (np.percentile, 98))
        )
        bumps.append((*((low + high) / 2)[:2], high[2], float((high - low)[:2].max())))
    return bumps


def carry(robot: Robot, start: Any, end: Any) -> None:
    """Grasp at one place and let go at another."""
    for place, width in ((start, 0.0), (end, robot.gripper.stroke)):
        if width == 0.0:
            robot.gripper.go_to(robot.gripper.stroke)
        for height in (ABOVE, 0.0):
            target = DOWN.copy()
            target[:3, 3] = np.add(place, (0, 0, height))
            robot.arm.move_pose(target, speed=0.5, straight=height == 0.0)
        robot.gripper.go_to(width, effort=30)
        target[2, 3] += ABOVE
        robot.arm.move_pose(target, speed=0.5)
