"""Whether a hand can grasp an object at all as it lies, as far as the table and the object itself let it."""

from __future__ import annotations

import numpy as np

from tamp.streams.hand.candidates import hangs_over, sample_pinches
from tamp.streams.hand.clearance import above_table, clear_of_object
from tamp.streams.hand.finger_closing import closed
from tamp.streams.hand.firmness import LOST, looseness
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace

PROBE, PROBES = 1, 3  # seed and rounds of the pinches that tell whether an object can be grasped as it lies


def graspable(workspace: Workspace, obj: str, placement: Placement) -> bool:
    """Whether any hand is found that can pinch an object as it lies, as far as the table lets it."""
    rng = np.random.default_rng(PROBE)
    return any(_pinched(workspace, obj, placement, rng) for _ in range(PROBES))


def _pinched(workspace: Workspace, obj: str, placement: Placement, rng: np.random.Generator) -> bool:
    hanging = placement.pose if hangs_over(workspace, obj, placement) else None
    pinches = sample_pinches(workspace, obj, rng, hanging=hanging)
    pinches = pinches.at(above_table(workspace, pinches, placement)) if len(pinches) else pinches
    pinches = pinches.at(clear_of_object(workspace, obj, pinches)) if len(pinches) else pinches
    # A rim is seldom as clear of the fingers as its sampled surface has it, and what is pinched there may tilt out.
    closings = (closed(workspace, obj, T, float(w)) for T, w in zip(pinches.T_object_tool, pinches.widths, strict=True))
    return any(grasp is not None and looseness(workspace, obj, grasp, placement.pose) < LOST for grasp in closings)
