import numpy as np

from tamp.streams.values import Placement
from tamp.streams.workspace import at_pose, standing
from tamp.task import Pose, Region
from tests.streams.tables import CUBE, RED, SLAB, at, workspace_of

HERE, THERE = (Placement(Pose((x, 0.0, 0.04)), ("table",)) for x in (0.0, 0.1))


def test_an_object_is_known_to_stand_at_its_start_and_at_its_goal(table):
    assert list(table.placements_of("red")) == [table.start["red"], table.goals["red"]]
    assert list(table.placements_of("slab")) == [table.start["slab"]]


def test_the_table_is_a_region_of_its_own():
    shelf = Region("shelf", (0.1, 0.1), (0.2, 0.2))
    workspace = workspace_of(CUBE, regions=(shelf,))
    assert workspace.region("shelf") is shelf
    assert workspace.region("table").size == workspace.task.table.size
    assert workspace.region("table").center == workspace.task.table.center


def test_of_several_placements_the_last_holds_first():
    facts = (at("red", HERE), ("AtConf", HERE), ("atpose", "cube", HERE), at("red", THERE))
    assert [fact[1] for fact in at_pose(facts)] == ["red", "cube", "red"]
    assert standing(facts) == {"red": THERE, "cube": HERE}


def test_the_surface_is_the_same_in_every_workspace(table):
    other = workspace_of(RED, SLAB, CUBE)
    assert set(table.surface) == {"red", "slab", "cube"}
    for name, points in table.surface.items():
        assert np.array_equal(points, other.surface[name])
        half = np.array(table.task.object(name).shape.size) / 2
        assert (np.abs(points) <= half + 1e-9).all()
