"""Non-negative least squares: the pushes that come nearest to a force."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

GAIN = 1e-9
"""A column whose gain is a smaller share of the target's and its own length is none."""

ORTHOGONAL = 1e-12
"""What is left of the target is at right angles to all columns, up to such a share of it."""


def nnls(A: Array, b: Array) -> tuple[Array, float]:
    """The x >= 0 that makes |A x - b| least, shape (n,), and that distance.

    Lawson and Hanson, "Solving Least Squares Problems", 1974, chapter 23. scipy's own has been seen to end the process
    (1.17: what was free was freed) where many columns depend on each other, as the edges of cones of contacts do.

    Args:
        A: shape (m, n).
        b: shape (m,).
    """
    lengths = np.linalg.norm(A, axis=0)
    usable = lengths > 0.0
    columns = A / np.where(usable, lengths, 1.0)
    bound, x = GAIN * float(np.linalg.norm(b)), np.zeros(A.shape[1])
    chosen: list[int] = []
    for _ in range(3 * A.shape[1]):
        gain = columns.T @ (b - columns[:, chosen] @ x[chosen])
        gain[chosen] = 0.0
        gain[~usable] = 0.0
        if not len(gain) or gain.max() <= bound:
            break
        best = int(gain.argmax())
        chosen.append(best)
        x = _inside(columns, b, chosen, x)
        if x[best] <= 0.0:  # rounding: what it gains is none
            usable[best] = False
        chosen = [index for index in chosen if x[index] > 0.0]
    return x / np.where(lengths > 0.0, lengths, 1.0), float(np.linalg.norm(columns @ x - b))


def _inside(columns: Array, b: Array, chosen: list[int], x: Array) -> Array:
    """The least squares of the chosen columns; those whose share would be negative are left out on the way there."""
    x, free = x.copy(), list(chosen)
    while free:
        wanted = _least_squares(columns[:, free], b)
        if (wanted > 0.0).all():
            x[:] = 0.0
            x[free] = wanted
            return x
        now = x[free]
        lower = wanted <= 0.0
        share = float((now[lower] / np.maximum(now[lower] - wanted[lower], 1e-300)).min())
        now = now + share * (wanted - now)
        now[lower & (now <= 1e-15)] = 0.0
        if (now > 0.0).all():
            now[int(np.argmin(np.where(lower, now, np.inf)))] = 0.0
        x[free] = now
        free = [index for index, value in zip(free, now, strict=True) if value > 0.0]
    return x


def _least_squares(A: Array, b: Array) -> Array:
    """The x that makes |A x - b| least, shape (n,), whatever its signs.

    By normal equations, refined once, which takes a tenth of the time where many bodies lean on each other; by singular
    values where columns depend on each other too much for that.
    """
    try:
        inverse = np.linalg.inv(A.T @ A)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(A, b, rcond=None)[0])
    x = inverse @ (A.T @ b)
    x += inverse @ (A.T @ (b - A @ x))
    if np.abs(A.T @ (b - A @ x)).max() <= ORTHOGONAL * float(np.linalg.norm(b)):
        return np.asarray(x)
    return np.asarray(np.linalg.lstsq(A, b, rcond=None)[0])
