"""A researcher's own samplers."""

import math

from tamp.streams.nothing import nothing
from tamp.streams.values import Grasp
from tamp.streams.workspace import Workspace
from tamp.task import Box, Pose

FROM_ABOVE = Pose.from_rpy((0.0, 0.0, 0.02), (math.pi, 0.0, 0.0))
SIDEWAYS = Pose.from_rpy((0.0, 0.0, 0.02), (math.pi, 0.0, math.pi / 2))


def from_above(context, obj):
    """Yield two grasps of a box: from above, across its y side and across its x side."""
    workspace: Workspace = context.scene
    shape = workspace.task.object(obj).shape
    assert isinstance(shape, Box)
    yield Grasp(FROM_ABOVE, shape.size[1])
    yield Grasp(SIDEWAYS, shape.size[0])


def no_grasp(context, obj):
    """Yield no grasp of anything."""
    context.fail(f"nobody grasps {obj}")
    yield from ()


NO_HANDS = {
    "sample-grasp": no_grasp,
    **dict.fromkeys(
        ("sample-regrasp", "sample-put-aside", "sample-laid-aside", "sample-exposed-aside", "sample-exposed-grasp"),
        nothing,
    ),
}
"""Of every stream that draws grasps."""


def no_slide(context, obj, placement, end=None):
    """Yield no slide of anything."""
    context.fail(f"nobody slides {obj}")
    yield from ()
