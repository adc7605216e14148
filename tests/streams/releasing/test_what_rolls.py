"""Falls over round edges: those that planning offers the checker accepts."""

from __future__ import annotations

import numpy as np

from tamp.checking.actions.fall import check_fall
from tamp.checking.scene import Scene, State
from tamp.checking.tolerances import DEFAULT
from tamp.streams.affordances.tilts import tilts
from tamp.streams.releasing.landing import aimed
from tamp.streams.values import Placement
from tamp.streams.workspace import TABLE
from tamp.task import Fall, Object, Pose, load_robot
from tests.streams.hand.test_rim_contact import hull
from tests.streams.tables import workspace_of


def round_thing(path, seed):
    """What is round but for a flat base, of random size, in a workspace of its own."""
    rng = np.random.default_rng(seed)
    turns, rings = np.linspace(0.0, 2 * np.pi, 16, endpoint=False), np.radians([-70, -45, -20, 0, 35])
    half = rng.uniform((0.05, 0.03, 0.025), (0.09, 0.05, 0.05))
    points = np.array([(np.cos(r) * np.cos(t), np.cos(r) * np.sin(t), np.sin(r)) for r in rings for t in turns]) * half
    points[:, 2] = np.maximum(points[:, 2], -rng.uniform(0.6, 0.9) * half[2])  # it stands on what is cut off below
    points[:, 2] -= points[:, 2].min()
    return workspace_of(Object("thing", hull(path, points), Pose((0.1, 0.1, 0.0))))


def test_the_checker_refuses_no_fall_of_a_round_thing_that_planning_offers(tmp_path):
    said, offered = list[str](), 0
    for seed in range(8):
        workspace = round_thing(tmp_path / f"thing{seed}.obj", seed)
        scene, place = Scene.of(workspace.task), Placement(Pose((0.1, 0.1, 0.0)), (TABLE,))
        found = tilts(workspace, "thing", place)
        for tilt in found[::3] + found[-3:]:
            fall = aimed(workspace, "thing", place, tilt.fall)
            if fall is not None:
                offered += 1
                state = State({"thing": fall[0].matrix}, np.array(load_robot("panda").home))
                check_fall(scene, state, Fall("thing", fall[-1]), DEFAULT, lambda kind, told, **more: said.append(told))
    assert said == []
    assert offered > 20
