"""What the problem says of flat objects, which takes a closer look at each: hands are sampled where they lie."""

from __future__ import annotations

import time
from dataclasses import dataclass

from tamp.streams.flat_faces import flat_faces
from tamp.streams.slides import slidable
from tamp.streams.topples import topplable
from tamp.streams.values import Placement
from tamp.streams.workspace import Workspace


@dataclass(frozen=True)
class Flatness:
    """A closer look at objects, for as long as there is time.

    Attributes:
        workspace: where they are.
        trusted: whether our own sampler of grasps is in use; of another one nobody knows what it may grasp.
        deadline: on the clock of time.monotonic [s]; past it no search begins any more that would need to know.
    """

    workspace: Workspace
    trusted: bool
    deadline: float

    def slidable(self, name: str, placement: Placement) -> bool:
        """Whether no hand can take the object from a placement or put it down there, unless it is slid away."""
        return self._looks and slidable(self.workspace, name, placement)

    def topplable(self, name: str, placement: Placement) -> bool:
        """The same where it has to be toppled."""
        return self._looks and topplable(self.workspace, name, placement)

    def lies_flat(self, name: str) -> bool:
        """Whether no hand can do so on the table on some face of the object."""
        return self._looks and bool(flat_faces(self.workspace, name))

    @property
    def _looks(self) -> bool:
        return self.trusted and time.monotonic() <= self.deadline
