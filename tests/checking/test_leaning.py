"""What leans on something that does not bear it, at once or after what it leaned on has left; as PyBullet has it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamp.checking import check
from tamp.task import At, Box, Cylinder, Mesh, Object, Plan, Pose, Sphere, Task, load_robot
from tamp.task.mesh.parts import convex_hull
from tests.checking.handmade import Hand, carry

HOME = load_robot("panda").home
HIGH = 0.12


def leaning(tilt: float, thick: float) -> Pose:
    """A board that leans towards x, its lower edge there at the origin, its upper one HIGH * sin(tilt) ahead."""
    x, z = -thick / 2, HIGH / 2
    return Pose.from_rpy(
        (x * np.cos(tilt) + z * np.sin(tilt), 0.0, z * np.cos(tilt) - x * np.sin(tilt)), (0.0, tilt, 0.0)
    )


def said(objects: list[Object], actions=()) -> str:
    goals = {o.name: o.goal.pose for o in objects if isinstance(o.goal, At)}
    plan = Plan("leaning", "panda", 0, {o.name: o.pose for o in objects}, HOME, goals, tuple(actions))
    return " ".join(problem.sentence for problem in check(Task("leaning", tuple(objects)), plan).problems)


@pytest.mark.parametrize(("wide", "mass", "stands"), [(0.012, 1.0, False), (0.03, 0.1, True)])
def test_what_stands_on_the_table_is_pushed_over_by_what_leans_on_it(wide, mass, stands):
    """Nearly upright, the board touches it only from the side."""
    tilt, thick = 0.15, 0.006
    domino = Object("domino", Box((wide, 0.08, 0.14)), Pose((HIGH * np.sin(tilt) + wide / 2, 0.0, 0.07)))
    board = Object("board", Box((thick, 0.1, HIGH)), leaning(tilt, thick), friction=1.0, mass=mass)
    assert ("off balance" not in said([domino, board])) == stands


@pytest.mark.parametrize(
    ("shape", "turn"), [(Cylinder(0.03, 0.1), np.pi / 2), (Sphere(0.03), 0.0), (Cylinder(0.03, 0.06), 0.0)]
)
@pytest.mark.parametrize(("tilt", "friction"), [(0.3, 0.5), (0.5, 0.5), (0.9, 0.5), (0.3, 1.0), (0.9, 1.0)])
def test_what_is_round_rolls_away_from_under_what_leans_on_it_where_friction_does_not_hold_both(
    shape, turn, tilt, friction
):
    """The line between the two places where it is touched lies in both cones, or it rolls; what stands does not."""
    radius, thick, rolls = 0.03, 0.02, turn > 0.0 or isinstance(shape, Sphere)
    ahead = (radius + radius * np.sin(tilt)) / np.cos(tilt) if rolls else 0.06 * np.tan(tilt) + radius
    can = Object("can", shape, Pose.from_rpy((ahead, 0.0, radius), (turn, 0.0, 0.0)), friction=friction)
    board = Object("board", Box((thick, 0.1, HIGH)), leaning(tilt, thick), friction=friction)
    assert ("off balance" in said([can, board])) == (rolls and friction == 0.5)


def test_what_has_given_way_to_something_does_not_lose_that_too():
    """The board leans on one of two walls; without that it gives way to the other, and falls without both."""
    near, far = (Pose((HIGH * np.sin(tilt) + 0.05, y, 0.07)) for tilt, y in ((0.25, -0.08), (0.38, 0.08)))
    ends = Pose((0.05, -0.3, 0.07)), Pose((0.05, 0.3, 0.07))
    walls = [
        Object(name, Box((0.1, 0.04, 0.14)), at, At(end), mass=1.0)
        for name, at, end in zip(("near", "far"), (near, far), ends, strict=True)
    ]
    board = Object("board", Box((0.02, 0.22, HIGH)), leaning(0.25, 0.02), friction=1.0)
    hand = Hand(HOME)
    first, second = (
        carry(hand, wall.name, wall.pose, wall.goal.pose, 0.04, ("table", "table"), grip_height=0.05) for wall in walls
    )
    assert "board" not in said([*walls, board], first)
    assert "board, which has given way to far, falls" in said([*walls, board], [*first, *second])


@pytest.mark.parametrize(
    ("shape", "turn", "rolls"), [(Cylinder(0.025, 0.08), np.pi / 2, True), (Box((0.05,) * 3), 0.0, False)]
)
def test_what_is_kept_from_rolling_down_a_slope_is_not_set_free(tmp_path, shape, turn, rolls):
    """A can that lies on a slope touches a block at its foot; in both simulators it rolls 33 cm without that."""
    slope = np.radians(12.0)
    ends = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.2 * np.tan(slope))]
    hull, file = convex_hull(np.array([(x, y, z) for y in (-0.05, 0.05) for x, z in ends])), tmp_path / "wedge.obj"
    lines = [*(f"v {x} {y} {z}" for x, y, z in hull.vertices), *(f"f {a} {b} {c}" for a, b, c in hull.faces + 1)]
    file.write_text("\n".join(lines))
    wedge = Object("wedge", Mesh(file), Pose((-0.05, -0.1, 0.0)), mass=1.0)
    on_slope = wedge.pose @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, -slope, 0.0))
    lying = Object("lying", shape, on_slope @ Pose.from_rpy((0.03, 0.0, 0.025), (turn, 0.0, 0.0)), mass=0.2)
    least = lying.pose.xyz[0] - (0.025 if turn else 0.025 * (np.cos(slope) + np.sin(slope)))
    block = Object("block", Box((0.03, 0.05, 0.08)), Pose((min(least, -0.05) - 0.0152, -0.1, 0.04)), mass=0.5)
    goal = Pose((0.1, 0.2, 0.04))
    actions = carry(Hand(HOME), "block", block.pose, goal, 0.05, ("table", "table"), grip_height=0.02)
    found = said([wedge, lying, replace(block, goal=At(goal))], actions)
    assert ("lying does not stay on wedge: it rolls down" in found) == rolls, found
    assert rolls or not found
