"""One pose for every object, or none, so that together they explain what was measured and do not share space.

Candidates are chosen for all objects at once by coordinate ascent with ejections (iterated conditional modes).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimation.candidates import Candidate
from tamp.perception.estimation.fusion import VOXEL, Cloud
from tamp.perception.estimation.models.object_model import ObjectModel
from tamp.perception.estimation.models.occupancy import shared

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

FREE = 1.0
"""What a cell of surface in free space costs, in explained points."""

OVERLAP = 1.0
"""What a cell of surface inside another object costs, in explained points."""

SAME = 0.004
"""Two of a mesh whose poses differ by less than this, over its symmetries, are in one place [m]."""

SWEEPS = 12

PLACE = 0.015
"""Objects change places where each has a candidate whose middle is this near to the other's [m]."""


class Selection:
    """The choice among candidates; candidates[i] are those of object i.

    Args:
        cloud: what was measured.
        models, candidates: of each object.
        present: whether every object that has candidates is there, as where masks show it: one is chosen whatever it
            costs. Meshes that are not quite what stands there overlap where the objects touch.
        before: a choice among some of these candidates, from which this one begins.

    Attributes:
        chosen: for each object the index of its candidate, -1 for none.
    """

    def __init__(
        self,
        cloud: Cloud,
        models: Sequence[ObjectModel],
        candidates: Sequence[Sequence[Candidate]],
        *,
        present: bool = False,
        before: Selection | None = None,
    ) -> None:
        self._models, self._candidates, self._present = models, candidates, present
        self._explained = [_Explained.by(found) for found in candidates]
        self._count = len(cloud.points)
        self._costs = [np.array([FREE * c.free_area for c in found]) for found in candidates]
        # Of candidates, not of objects: what shares space stays so among more candidates, and for all of a mesh.
        self._overlaps: dict[frozenset[Candidate], float] = {} if before is None else before._overlaps
        self.chosen: list[int] = [-1] * len(models) if before is None else list(before.chosen)

    def solve(self) -> None:
        """Choose, starting from the objects whose best candidate explains most."""
        best = [float(self._worth(i).max(initial=0.0)) for i in range(len(self._models))]
        order = sorted(range(len(best)), key=lambda i: -best[i])
        for _ in range(SWEEPS):
            before = list(self.chosen)
            for i in order:
                self._choose(i)
            if self.chosen == before and not self._insert(order):
                return

    def covered(self, without: Collection[int] = ()) -> Array:
        """How well each point is explained by what is chosen, 0..1, perhaps without some objects."""
        best = np.zeros(self._count)
        for i, k in enumerate(self.chosen):
            if k >= 0 and i not in without:
                found = self._candidates[i][k]
                best[found.points] = np.maximum(best[found.points], found.weights)
        return best

    def gains(self, i: int) -> Array:
        """What each candidate of an object would add to the others' choice, in points, shape (n,)."""
        clash = np.array([self.clash(i, k) for k in range(len(self._candidates[i]))])
        gain: Array = self._gains_but_for_clashes(i) - OVERLAP * clash
        return gain

    def _gain(self, i: int, k: int) -> float:
        return float(self._gains_but_for_clashes(i)[k]) - OVERLAP * self.clash(i, k)

    def total(self) -> float:
        """What the choice is worth, in points."""
        worth = float(credit(self.covered()).sum())
        for i, k in enumerate(self.chosen):
            if k >= 0:
                worth -= float(self._costs[i][k]) + OVERLAP * self.clash(i, k) / 2
        return worth

    def lead_over_exchange(self, i: int) -> float:
        """How much the choice is better than the best in which an object and one of another mesh change places.

        In points; infinite where no candidates are at each other's places. Objects that shape and colour hardly tell
        apart have a small one.
        """
        kept, now, lead = list(self.chosen), self.total(), float("inf")
        if kept[i] < 0:
            return lead
        for j, m in enumerate(kept):
            if j == i or m < 0 or self._models[j] is self._models[i]:
                continue
            there, here = self.at(i, self.center(j, m)), self.at(j, self.center(i, kept[i]))
            if not there or not here:
                continue
            self.chosen[i], self.chosen[j] = there[0], here[0]
            lead = min(lead, now - self.total())
            self.chosen = list(kept)
        return max(0.0, lead)

    def lead_over_absent(self, i: int) -> float:
        """How much more an object adds than the best that stands nowhere would if it were not there, in points.

        Infinite where there is none; one of its own mesh is told apart from it by nothing.
        """
        kept, most = list(self.chosen), 0.0
        gain = self._gain(i, kept[i])
        self.chosen[i] = -1
        for j, k in enumerate(kept):
            if k < 0 and self._models[j] is not self._models[i]:
                most = max(most, self._most_gain(j, most)[1])
        self.chosen = kept
        return max(0.0, gain - most) if most > 0 else float("inf")

    def center(self, i: int, k: int) -> Array:
        """The middle of an object's surface at one of its candidates, shape (3,) [m]."""
        T = self._candidates[i][k].pose
        center: Array = T[:3, :3] @ self._models[i].center + T[:3, 3]
        return center

    def at(self, i: int, place: Array) -> list[int]:
        """The candidates of an object near a place, those that explain most by themselves first."""
        worth = self._worth(i)
        near = [k for k in range(len(worth)) if np.linalg.norm(self.center(i, k) - place) < PLACE]
        return sorted(near, key=lambda k: -float(worth[k]))

    def _gains_but_for_clashes(self, i: int) -> Array:
        gain: Array = self._explained[i].beyond(credit(self.covered(without=(i,)))) - self._costs[i]
        return gain

    def _choose(self, i: int) -> None:
        """Choose what gains most; where all are present, also what gains nothing."""
        self.chosen[i] = self._most_gain(i, -np.inf if self._present else 0.0)[0]

    def _most_gain(self, i: int, least: float) -> tuple[int, float]:
        """The candidate that gains more than so much and most, the first of those, and its gain; -1 for none.

        Who cannot even without clashes is not asked for these.
        """
        bounds = self._gains_but_for_clashes(i)
        best, most = -1, least
        for k in np.argsort(-bounds, kind="stable").tolist():
            if bounds[k] < most or bounds[k] <= least:
                break
            gain = bounds[k] - OVERLAP * self.clash(i, k)
            if gain > most or (gain == most and k < best):
                best, most = k, gain
        return best, most

    def _insert(self, order: Sequence[int]) -> bool:
        """Put an object where it explains more, let what was in its way choose again, and keep that if all gain by it.

        An ejection chain of one link (Glover, 1996): what is in the way may be several objects, each of which alone
        would be better off where it is. Of each place the candidate that explains most is tried.
        """
        now = self.total()
        before = list(self.chosen)
        for i in order:
            worth = self._worth(i)
            gain = 0.0 if before[i] < 0 else self._gain(i, before[i])
            tried: set[int] = set()
            for k in np.argsort(-worth, kind="stable").tolist():
                if worth[k] <= gain + 1.0:
                    break
                if k in tried:
                    continue
                tried.update(self.at(i, self.center(i, k)))
                moved = [j for j in order if j != i and before[j] >= 0 and self._in_the_way(i, k, j)]
                self.chosen[i] = k
                for j in moved:
                    self.chosen[j] = -1
                for j in moved:
                    self._choose(j)
                if self.total() > now + 1.0:
                    return True
                self.chosen = list(before)
        return False

    def _in_the_way(self, i: int, k: int, j: int) -> bool:
        """Whether what is chosen for j shares space or explained points with candidate k of i."""
        a, b = self._candidates[i][k], self._candidates[j][self.chosen[j]]
        return self._overlap(i, k, j, self.chosen[j]) > 0 or bool(np.isin(a.points, b.points).any())

    def _worth(self, i: int) -> Array:
        """What each candidate of an object explains by itself, less what it costs, in points, shape (n,)."""
        worth: Array = self._explained[i].beyond(np.zeros(self._count)) - self._costs[i]
        return worth

    def clash(self, i: int, k: int) -> float:
        """Cells of surface that a candidate shares with what is chosen for the others."""
        return sum(self._overlap(i, k, j, m) for j, m in enumerate(self.chosen) if j != i and m >= 0)

    def meeting(self, i: int) -> list[int]:
        """The objects whose chosen candidates take up space that an object's chosen one does too."""
        k = self.chosen[i]
        return [j for j, m in enumerate(self.chosen) if min(k, m) >= 0 and j != i and self._overlap(i, k, j, m) > 0]

    def _overlap(self, i: int, k: int, j: int, m: int) -> float:
        a, b = self._candidates[i][k], self._candidates[j][m]
        pair = frozenset((a, b))
        if pair not in self._overlaps:
            near = np.linalg.norm(self.center(i, k) - self.center(j, m)) < SAME
            if self._models[i] is self._models[j] and near and self._models[i].apart(a.pose, b.pose) < SAME:
                # Neither is inside the other; two of a kind in one place are one.
                self._overlaps[pair] = self._models[i].area / VOXEL**2
            else:
                self._overlaps[pair] = _shared(self._models[i], a.pose, self._models[j], b.pose) + _shared(
                    self._models[j], b.pose, self._models[i], a.pose
                )
        return self._overlaps[pair]


@dataclass(frozen=True, eq=False)
class _Explained:
    """What all candidates of an object explain: candidate, point and credit, shape (m,) each."""

    count: int
    candidate: NDArray[np.int64]
    point: NDArray[np.int64]
    credit: Array

    @staticmethod
    def by(found: Sequence[Candidate]) -> _Explained:
        if not found:
            return _Explained(0, np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0))
        candidate = np.repeat(np.arange(len(found)), [len(c.points) for c in found])
        point, weight = np.concatenate([c.points for c in found]), np.concatenate([c.weights for c in found])
        return _Explained(len(found), candidate, point, credit(weight))

    def beyond(self, covered: Array) -> Array:
        """What each candidate explains more than has the credits `covered`, in points, shape (count,)."""
        more = np.maximum(self.credit - covered[self.point], 0.0)
        return np.bincount(self.candidate, more, self.count).astype(np.float64)


def credit(weights: Array) -> Array:
    """What points that are explained so well, 0..1, count: w (2 - w), so that half is three quarters.

    Colours of what is in shade are half unlike those of its mesh. What lies on a large surface there, and fits its
    colours a little better, would else count for more than where it explains points that nothing else does.
    """
    return np.asarray(weights * (2 - weights))


def _shared(a: ObjectModel, T_a: Array, b: ObjectModel, T_b: Array) -> float:
    """Cells of a's surface that are inside b."""
    T = np.linalg.inv(T_b) @ T_a
    if np.linalg.norm(T[:3, :3] @ a.center + T[:3, 3] - b.center) > (a.diameter + b.diameter) / 2:
        return 0.0
    return shared(a.occupancy, b.occupancy, T) / VOXEL**2
