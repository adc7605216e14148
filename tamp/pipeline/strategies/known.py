"""What a search is told of single objects, as earlier searches and executions of the same run have shown it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType


@dataclass(frozen=True)
class Known:
    """Nothing, at the beginning of a run.

    Attributes:
        hopeless: objects that do not reach their goals even alone from where they stand -> why.
        unturned: objects that two grasps do not turn over from where they are.
        unsteady: objects that have ended elsewhere again and again, whatever was planned for them.
    """

    hopeless: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    unturned: Collection[str] = ()
    unsteady: Collection[str] = ()


NOTHING = Known()
