from __future__ import annotations

import tamp
from tamp.domains.skill import Question
from tamp.domains.tabletop.skills.slide import affordances
from tamp.pipeline.prepare import prepare
from tamp.pipeline.strategies.serialization.clear_space import stuck
from tamp.streams.values import Configuration
from tamp.task import At, Box, Object, Pose, Task, load_robot

AT_HOME = Question(Configuration(load_robot("panda").home, 0.08))

WALL = Object("wall", Box((0.04, 0.4, 0.1)), Pose((0.1, 0.2, 0.05)), At(Pose((0.1, 0.2, 0.05))), mass=2.0)
PACKET = Object(
    "packet", Box((0.07, 0.15, 0.09)), Pose((0.16, 0.2, 0.045)), At(Pose.from_rpy((0.1, -0.2, 0.045), (0.0, 0.0, 0.5)))
)
"""There is no room for a finger between the packet and the wall, which must stay, and which no hand can lift."""


def test_what_a_wall_hems_in_is_pushed_into_the_open_and_taken_there():
    task = Task("hemmed", (WALL, PACKET))
    setup = prepare(task)
    assert stuck(setup.observe(setup.start), ["wall", "packet"]) == {"packet"}
    plan = tamp.plan(task, seed=0)
    done = [action.name for action in plan.actions if not action.name.startswith("move")]
    assert done[:2] == ["slide", "pick"]
    assert tamp.check(task, plan).accepted


def test_only_what_is_hemmed_in_or_cannot_be_grasped_is_pushed_to_its_goal():
    def pushed(x: float) -> bool:
        packet = Object("packet", PACKET.shape, Pose((x, 0.2, 0.045)), At(Pose((x, 0.1, 0.045))))
        setup = prepare(Task("beside", (WALL, packet)))
        workspace = setup.observe(setup.start)
        return any(fact[0] == "SlidableTo" for fact in affordances(workspace, AT_HOME))

    assert pushed(0.16) and not pushed(0.25)
