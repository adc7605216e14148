"""Where everything stands at one moment: an immutable value, cheap to copy with one thing changed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Scene:
    """Poses of the objects that stand somewhere, and what the gripper does.

    Attributes:
        poses: object name -> `T_world_object`, shape (4, 4), read-only. A held object is not among them.
        held: (object name, `T_tool_object`) of what the gripper holds, or None.
        opening: distance between the finger pads [m].
    """

    poses: Mapping[str, Matrix] = field(default_factory=dict)
    held: tuple[str, Matrix] | None = None
    opening: float = 0.0

    def __post_init__(self) -> None:
        frozen = MappingProxyType({name: _read_only(T) for name, T in self.poses.items()})
        object.__setattr__(self, "poses", frozen)
        if self.held is not None:
            object.__setattr__(self, "held", (self.held[0], _read_only(self.held[1])))

    def moved(self, name: str, T_world_object: Matrix) -> Scene:
        """This scene with the object `name` standing at another pose; adds it where it was absent."""
        return replace(self, poses={**self.poses, name: T_world_object})

    def attached(self, name: str, T_tool_object: Matrix, opening: float) -> Scene:
        """This scene with `name` held by fingers `opening` [m] apart instead of standing anywhere."""
        return replace(self.without(name), held=(name, T_tool_object), opening=opening)

    def detached(self, name: str, T_world_object: Matrix, opening: float | None = None) -> Scene:
        """This scene with the held object let go at a pose, the fingers `opening` [m] apart (default: as they are)."""
        kept = None if self.held is not None and self.held[0] == name else self.held
        wide = self.opening if opening is None else opening
        return replace(self, poses={**self.poses, name: T_world_object}, held=kept, opening=wide)

    def without(self, name: str) -> Scene:
        """This scene without the object `name`, standing or held."""
        kept = None if self.held is not None and self.held[0] == name else self.held
        return replace(self, poses={n: T for n, T in self.poses.items() if n != name}, held=kept)


def _read_only(T: Matrix) -> Matrix:
    if not T.flags.writeable and T.dtype == np.float64:
        return T
    copy = np.array(T, dtype=np.float64)
    copy.setflags(write=False)
    return copy
