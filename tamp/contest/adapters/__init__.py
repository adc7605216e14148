"""Solutions written against OCRTOC's own interfaces, run as solutions of this contest.

- ocrtoc2024: an agent class whose `draw_action` answers observations, ten times a second
- ocrtoc2021: the Python classes over ROS: cameras, transforms, manipulator, gripper, the solution action
- messages: the few ROS messages that these take and give

Imports NumPy, the standard library and `tamp.contest.api` only: it is seen by every solution.
"""

from tamp.contest.adapters.ocrtoc2021 import Solution2021
from tamp.contest.adapters.ocrtoc2024 import Agent2024, AgentBase

__all__ = ["Agent2024", "AgentBase", "Solution2021"]
