"""How much an estimate is to be trusted: what was seen of it, what contradicts it, and what else would do as well."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tamp.perception.estimation.candidates import Candidate
from tamp.perception.estimation.selection import Selection, credit
from tamp.perception.estimation.verification import CLOSER, SHOWN, Verified

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

AHEAD = 0.06
"""An estimate that explains so much more than the next, as a share, is trusted by two thirds."""

GOES_ON = 1.0
"""What goes on beyond itself along so much of its border, as a share, is trusted by a third; what only touches other
things does so along less."""

SCRAP = 0.06
"""A sight of so much of an object's surface, as a share, is trusted by two thirds: much else has such a scrap of it."""


ITS_OWN = 1.5
"""How much less is trusted what others explain too: what does so by a half is trusted by a third."""


def confidence(best: Candidate, gain: float, clash: float, ahead: float, goes_on: float) -> float:
    """How much to trust an estimate, 0..1.

    Args:
        best: what it comes from.
        gain: what it adds to what others explain, in points.
        clash: surface that it shares with others, in points.
        ahead: how far the next best is behind, see `lead`.
        goes_on: along how much of its border surface goes on that nothing explains, see `Left.goes_on`.
    """
    seen = (1 - np.exp(-gain / 60)) * (1 - np.exp(-((best.hits / SCRAP) ** 2)))
    clean = np.exp(-8 * best.violations - clash / max(1.0, gain) - (goes_on / GOES_ON) ** 2)
    own = max(0.0, gain) / max(1.0, float(credit(best.weights).sum()))
    return float(np.clip(seen * clean * own**ITS_OWN * (1 - np.exp(-ahead)), 0.0, 1.0))


def lead(
    selection: Selection, i: int, gains: Array, others: Sequence[int], verified: Verified, told: float = 0.0
) -> float:
    """How far the next best is behind, in scales at which two thirds are trusted.

    Elsewhere, or with an object in its place that was found nowhere, it is what the chosen pose explains more. In the
    same place, turned round or with another object in exchange, it is how much better residuals are; what is explained
    decides only where nothing was fitted beside. Whole pictures may tell, by the share `told`, that it is not turned
    round, which a place's points may hardly do.
    """
    k = verified.candidate
    gain = max(1.0, float(gains[k]))
    here = set(selection.at(i, selection.center(i, k)))
    away = (gain - max((float(gains[o]) for o in others if o not in here), default=0.0)) / gain / AHEAD
    away = min(away, selection.lead_over_absent(i) / gain / AHEAD)
    if np.isfinite(verified.lead):
        in_place = max(verified.lead / CLOSER, min(verified.exchanged / CLOSER, told / SHOWN))
        return max(0.0, min(away, in_place))
    turned = gain - max((float(gains[o]) for o in others if o in here), default=0.0)
    in_place = min(turned, selection.lead_over_exchange(i)) / gain / AHEAD
    return max(0.0, min(away, in_place))
