"""Bringing near at once what will hardly reach its goal and is far from it: that gains most, while there is time."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

from tamp.pipeline.goals import away
from tamp.pipeline.nearness import bring_near
from tamp.pipeline.prospects import Prospects

FAR = 0.15  # from its goal (EDE) is what is brought near before all else was tried [m]


@dataclass
class Early:
    """Objects without hope, each brought near once.

    Attributes:
        prospects: tell who has no hope.
        allowed: whether anything shall be brought merely near.
    """

    prospects: Prospects
    allowed: bool = False
    _tried: set[str] = field(default_factory=set)

    def bring(self, name: str, left: Collection[str], kept: Collection[str]) -> bool:
        """Bring an object near if it has no hope and is far, but not to where those shall be that have; whether it was.

        Args:
            name: the object.
            left: all objects that are not at their goals.
            kept: objects that must stay at theirs.
        """
        asker = self.prospects.asker
        goals, hopeless = asker.workspace.goals.keys(), self.prospects.beyond_hope(left)
        if not self.allowed or name not in hopeless & goals - self._tried:
            return False
        self._tried.add(name)
        return away(asker.workspace, name) > FAR and bring_near(asker, {name}, kept, (goals & {*left}) - hopeless)
