"""Which points are worth their cost: the Pareto front, and the cheapest that is good enough."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demverify.frames import Floats


def front(cost: Floats, error: Floats) -> NDArray[np.bool_]:
    """Of points with a cost and an error (k,), those that no other beats: none is as good in both and better in one. NaN, inf: never on it."""
    cost, error = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    known = np.isfinite(cost) & np.isfinite(error)
    return np.array([
        bool(known[k]) and not (known & (cost <= cost[k]) & (error <= error[k]) & ((cost < cost[k]) | (error < error[k]))).any()
        for k in range(len(cost))
    ], dtype=bool)  # fmt: skip


def cheapest(cost: Floats, error: Floats, target: float) -> int | None:
    """The point of least cost with an error of at most `target`; None if there is none."""
    cost, error = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    good = np.flatnonzero(np.isfinite(cost) & (error <= target))
    return int(good[np.argmin(cost[good])]) if len(good) else None
