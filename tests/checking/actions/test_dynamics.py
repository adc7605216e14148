from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from tamp.checking import check
from tamp.formats.obj import box_obj
from tamp.task import (
    Action,
    At,
    Attachment,
    Box,
    Grip,
    Inertia,
    Mesh,
    Move,
    Object,
    Plan,
    Pose,
    Release,
    Task,
    Trajectory,
)
from tests.checking.handmade import DOWN, OPEN, Hand, above, carry, timed, two_boxes
from tests.task.meshes import parts_obj

UPRIGHT = Pose((0.05, -0.2, 0.13))


def said(task, plan):
    return " ".join(problem.sentence for problem in check(task, plan).problems)


def weighing(task, mass):
    return replace(task, objects=tuple(replace(o, mass=mass) if o.name == "red" else o for o in task.objects))


def slowed(plan, factor):
    """The plan with all its motions so many times as long."""

    def slower(step):
        if not isinstance(step, Move):
            return step
        t = step.trajectory
        return replace(step, trajectory=Trajectory(t.times * factor, t.positions, t.velocities / factor))

    return replace(plan, actions=tuple(replace(a, steps=tuple(map(slower, a.steps))) for a in plan.actions))


def test_what_friction_hardly_carries_is_not_hurried():
    task, plan = two_boxes()
    assert check(weighing(task, 4.0), plan).accepted
    heavy = weighing(task, 6.5)
    assert "red slips in the fingers: a lift motion" in said(heavy, plan)
    assert "slips" not in said(heavy, slowed(plan, 4.0))


def turned_level(mass):
    """A bar that is gripped near its top, turned until it is nearly level in the hand, and back."""
    bar = Object("red", Box((0.03, 0.03, 0.26)), UPRIGHT, At(UPRIGHT), mass=mass)
    hand, grip = Hand(two_boxes()[1].home), Pose((0.0, 0.0, 0.11), DOWN)
    held, tool = Attachment("red", grip.inverse()), UPRIGHT @ grip
    touching = frozenset({("robot", "red"), ("red", "table")})
    level = Pose((0.05, -0.2, 0.45), DOWN) @ Pose.from_rpy((0.0, 0.0, 0.0), (0.0, -1.3, 0.0))
    to, reach = hand.free(above(tool)), hand.line(tool)
    up, over, back = hand.line(above(tool, 0.2)), hand.free(level), hand.free(above(tool, 0.2))
    down, away = hand.line(tool), hand.line(above(tool))
    lift = Move("lift", up, 0.03, held, touching)
    lower = Move("lower", down, 0.03, held, touching)
    ways = (Move("transfer", over, 0.03, held), Move("transfer", back, 0.03, held))
    actions = (
        Action("move", (), (Move("transit", to, OPEN),)),
        Action("pick", ("red",), (Move("approach", reach, OPEN, contacts=touching), Grip(held, 0.03), lift)),
        Action("move", ("red",), ways),
        Action("place", ("red",), (lower, Release("red", UPRIGHT, OPEN), Move("retreat", away, OPEN))),
    )
    return Task("bar", (bar,)), Plan(
        "bar", "panda", 0, {"red": UPRIGHT}, two_boxes()[1].home, {"red": UPRIGHT}, actions
    )


@pytest.mark.parametrize(("mass", "held"), [(0.3, True), (1.5, False)])
def test_what_hangs_from_the_hand_is_not_turned_level_where_it_would_swing_down(mass, held):
    task, plan = turned_level(mass)
    found = [problem for problem in check(task, plan).problems if "red slips in the fingers" in problem.sentence]
    assert (not found) == held
    assert {problem.action for problem in found} <= {2}


def nodding(moment):
    """A bar that is held by its middle, far above the table, and tipped up and down about the closing axis."""
    bar = Object("red", Box((0.28, 0.03, 0.03)), Pose((0.05, -0.1, 0.015)), mass=1.0)
    if moment is not None:
        bar = replace(bar, inertia=Inertia(Pose(), (moment / 10, moment, moment)))
    hand, grip = Hand(two_boxes()[1].home), Pose((0.0, 0.0, 0.0), DOWN)
    held, tool = Attachment("red", grip.inverse()), bar.pose @ grip
    to, reach, up = hand.free(above(tool)), hand.line(tool), hand.line(above(tool, 0.35))
    level = np.array(hand.q)
    ends = [level + np.eye(7)[5] * turn for turn in (0.0, 0.45, -0.45)]
    ways = tuple(Move("transfer", timed(np.array(pair), hand.spec), 0.03, held) for pair in itertools.pairwise(ends))
    lift = Move("lift", up, 0.03, held, frozenset({("red", "table")}))
    actions = (
        Action("move", (), (Move("transit", to, OPEN),)),
        Action("pick", ("red",), (Move("approach", reach, OPEN), Grip(held, 0.03), lift)),
        Action("move", ("red",), ways),
    )
    return Task("bar", (bar,)), Plan("bar", "panda", 0, {"red": bar.pose}, two_boxes()[1].home, {}, actions)


@pytest.mark.parametrize(("moment", "held"), [(None, True), (0.002, True), (0.015, True), (0.05, False)])
def test_what_is_bulky_is_not_turned_faster_than_friction_holds(moment, held):
    task, plan = nodding(moment)
    found = [problem for problem in check(task, plan).problems if "red slips in the fingers" in problem.sentence]
    assert (not found) == held
    assert {problem.action for problem in found} <= {2}
    assert not any("slips" in problem.sentence for problem in check(task, slowed(plan, 4.0)).problems)


def test_a_spike_of_acceleration_is_seen_after_hours_of_rest():
    task, plan = two_boxes()
    heavy, lift = weighing(task, 6.5), plan.actions[1].steps[-1]
    t = lift.trajectory
    waited = Trajectory(
        np.concatenate([[0.0], t.times + 1e4]),
        np.concatenate([t.positions[:1], t.positions]),
        np.concatenate([t.velocities[:1], t.velocities]),
    )
    steps = (*plan.actions[1].steps[:-1], replace(lift, trajectory=waited))
    later = replace(plan, actions=(plan.actions[0], replace(plan.actions[1], steps=steps), *plan.actions[2:]))
    assert "red slips in the fingers: a lift motion" in said(heavy, later)


@pytest.mark.parametrize(("deep", "mass", "pries"), [(0.004, 1.0, True), (0.004, 0.6, False), (0.018, 1.0, False)])
def test_what_is_heavy_to_the_side_to_which_a_finger_closes_pries_the_fingers_open(tmp_path, deep, mass, pries):
    """An L is held by the end of its stem, so deep between the fingers; in simulators the first turns and falls."""
    (tmp_path / "gallows.obj").write_text(
        parts_obj([((-0.02, -0.02, -0.075), (0.02, 0.02, 0.075)), ((-0.02, 0.02, -0.075), (0.02, 0.25, -0.045))])
    )
    start, end = Pose((0.05, -0.3, 0.075)), Pose((0.05, -0.05, 0.075))
    gallows = Object("red", Mesh(tmp_path / "gallows.obj"), start, At(end), mass=mass)
    home = two_boxes()[1].home
    actions = carry(Hand(home), "red", start, end, 0.04, ("table", "table"), 0.084 - deep)
    plan = Plan("gallows", "panda", 0, {"red": start}, home, {"red": end}, tuple(actions))
    found = said(Task("gallows", (gallows,)), plan)
    assert ("pries the fingers open" in found) == pries
    assert bool(found) == pries
    assert not pries or "pries" not in said(Task("gallows", (gallows,)), slowed(plan, 4.0))


def tapered(degrees):
    """An OBJ file of a block of 5 by 5 by 6 cm whose flanks come together upwards, each at that slope."""
    lines = []
    for line in box_obj("block", (-0.025, -0.025, -0.03), (0.025, 0.025, 0.03)).splitlines():
        if line.startswith("v "):
            x, y, z = map(float, line.split()[1:])
            line = f"v {x} {y - np.sign(y) * z * np.tan(np.radians(degrees))} {z}"
        lines.append(line)
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("degrees", "friction", "mass", "held"),
    [
        (13.0, 0.3, 0.3, True),
        (13.0, 0.3, 1.0, False),
        (15.5, 0.3, 0.02, True),
        (15.5, 0.3, 0.1, False),
        (25.0, 0.6, 0.3, True),
        (28.0, 0.6, 0.3, False),
    ],
)
def test_pads_squeeze_out_what_tapers_where_little_friction_is_left_beside_its_slope(
    tmp_path, degrees, friction, mass, held
):
    """It is gripped by flanks that friction just holds without a weight: two simulators lost it at once."""
    mesh = tmp_path / "block.obj"
    mesh.write_text(tapered(degrees))
    start, end = Pose((0.05, -0.2, 0.03)), Pose((0.05, 0.2, 0.03))
    task = Task("taper", (Object("red", Mesh(mesh), start, At(end), mass=mass, friction=friction),))
    home = two_boxes()[1].home
    actions = carry(Hand(home), "red", start, end, 0.05, ("table", "table"), 0.01)
    found = said(task, slowed(Plan("taper", "panda", 0, {"red": start}, home, {"red": end}, tuple(actions)), 1.3))
    assert ("red slips off the pads, whose rims press on a slope" in found) != held, found
    assert bool(found) != held, found
