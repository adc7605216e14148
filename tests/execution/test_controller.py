from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.execution.controller import Operator, positions_at, set_points
from tamp.execution.simulator import ROBOT, STEP, Touch
from tamp.task import Attachment, Box, Grip, Object, Pose, Trajectory, load_robot
from tamp.world.robot.model import robot_model


def cubic(coefficients, times):
    """A trajectory sampled from a cubic polynomial per joint; coefficients of shape (4, joints)."""
    c, t = np.asarray(coefficients, dtype=float), np.asarray(times, dtype=float)[:, None]
    return Trajectory(
        np.asarray(times, dtype=float),
        c[0] + c[1] * t + c[2] * t**2 + c[3] * t**3,
        c[1] + 2 * c[2] * t + 3 * c[3] * t**2,
    )


@given(
    c=st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), min_size=4, max_size=4),
    cuts=st.lists(st.floats(0.05, 0.5), min_size=1, max_size=6),
    at=st.floats(0, 1),
)
def test_a_cubic_is_its_own_hermite_curve(c, cuts, at):
    times = np.r_[0.0, np.cumsum(cuts)]
    trajectory = cubic(c, times)
    t = at * times[-1]
    exact = np.array([1, t, t**2, t**3]) @ np.asarray(c)
    assert positions_at(trajectory, np.array([t]))[0] == pytest.approx(exact, abs=1e-9)


def test_the_arm_rests_before_and_after():
    trajectory = cubic([[0.0], [0.0], [3.0], [-2.0]], [0.0, 0.5, 1.0])
    assert positions_at(trajectory, np.array([-1.0, 2.0])).ravel() == pytest.approx([0.0, 1.0])


def test_set_points_lead_from_start_to_end():
    trajectory = cubic([[0.1], [0.0], [3.0], [-2.0]], np.linspace(0, 1, 7))
    q, v = set_points(trajectory, STEP)
    assert len(q) == len(v) == 240
    assert q[0] == pytest.approx([0.1])
    assert q[0] + v.sum(axis=0) * STEP == pytest.approx([1.1])


def test_a_trajectory_of_one_sample_stands_still():
    trajectory = Trajectory(np.zeros(1), np.array([[0.3, 0.4]]), np.zeros((1, 2)))
    q, v = set_points(trajectory, STEP)
    assert q.tolist() == [[0.3, 0.4]]
    assert not v.any()


class StiffWorld:
    """A hand over a box that nothing moves: fingers that stop together touch it on both sides from its middle alone."""

    spec = load_robot("panda")

    def __init__(self, aside: float) -> None:
        self.robot, self.q, self.aside = self, np.array(self.spec.home), aside
        self.objects = {"box": Object("box", Box((0.04, 0.04, 0.04)), Pose(), mass=0.1)}
        self.middle = self.tool().xyz[1] + aside

    def configuration(self):
        return self.q

    def command(self, q, velocity=None):
        self.q = np.array(q)

    def tool(self):
        return Pose.from_matrix(robot_model(self.spec).forward(self.q))

    def touching(self, name):
        off = self.tool().xyz[1] - self.middle
        return off < 2e-4, off > -2e-4

    def touches(self):
        return tuple(
            Touch("box", ROBOT, (0.0, side, 0.0), 0.0, 20.0)
            for side, feels in zip((-1.0, 1.0), self.touching("box"), strict=True)
            if feels
        )

    def opening(self):
        return 0.042

    def finger_speed(self):
        return 0.0

    def squeeze(self, force):
        pass

    def open_to(self, opening):
        pass

    def pose(self, name):
        return Pose()

    def step(self, count=1):
        pass


@pytest.mark.parametrize(("aside", "missed"), [(0.0, False), (0.002, False), (-0.002, False), (0.006, True)])
def test_the_arm_gives_way_to_what_one_finger_alone_touches_until_the_other_does_too(aside, missed):
    world = StiffWorld(aside)
    lost = Operator(world).grip(Grip(Attachment("box", Pose()), 0.04))
    assert (lost is not None) == missed
    assert missed or abs(world.tool().xyz[1] - world.middle) <= 2e-4


@pytest.mark.parametrize("named", [(), (Touch("box", ROBOT, (1.0, 0.0, 0.0), 0.0, 20.0),)])
def test_the_arm_stays_where_no_touch_says_to_which_side_it_should_give_way(monkeypatch, named):
    world = StiffWorld(0.002)
    monkeypatch.setattr(StiffWorld, "touches", lambda world: named)
    before = world.q.copy()
    Operator(world).grip(Grip(Attachment("box", Pose()), 0.04))
    assert (world.q == before).all()
