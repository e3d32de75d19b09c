"""Observed order of convergence: the slope of log error over log step, where errors follow a power of the step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demverify.frames import Floats

LARGEST = 0.1  # relative errors above are not small
FLAT = 0.3  # local slopes below, at the small end, are a floor: rounding, or another model
SCATTER = 0.4  # rms of ln(error) about the line, up to which errors follow a power: the phases of the steps scatter them
LEAST = 4  # points of a fit


@dataclass(frozen=True)
class Order:
    """A fitted order. half: half the width of its 95 % confidence interval. longest, shortest: steps of the range of the fit. points: in it."""

    value: float
    half: float
    longest: float
    shortest: float
    points: int

    def within(self, expected: float, least: float) -> bool:
        """Whether the expected order lies in the interval, widened to +-least."""
        return abs(self.value - expected) <= max(self.half, least)


def fit_order(steps: Floats, errors: Floats) -> Order | None:
    """The order over the asymptotic range: of the rows of steps that end with the shortest, hold half of all at least, and along which a power of the
    step fits within SCATTER, the one that gives the narrowest interval; all of them where none does. (A longer row narrows it, until it bends.)

    The interval is that of the row taken: as the row is chosen, it holds the order a little less often than in 95 of 100 cases.
    steps, errors: (k,), in any order. Left out before: errors above LARGEST, that are zero or no number, and a floor at the small end, where a
    shorter step no longer helps. None where fewer than LEAST are left.
    """
    h, e = _usable(np.asarray(steps, dtype=float), np.asarray(errors, dtype=float))
    if len(h) < LEAST:
        return None
    fits = [_fit(h[a:], e[a:]) for a in range(len(h) - max(LEAST, (len(h) + 1) // 2) + 1)]
    return min((order for order, off in fits if off <= SCATTER), key=lambda order: order.half, default=fits[0][0])


def _usable(h: Floats, e: Floats) -> tuple[Floats, Floats]:
    """From the longest step to the shortest, without the floor."""
    known = np.isfinite(e) & (e > 0.0) & (e < LARGEST)
    order = np.argsort(-h[known])
    h, e = h[known][order], e[known][order]
    while len(h) > 1 and np.log(e[-2] / e[-1]) < FLAT * np.log(h[-2] / h[-1]):
        h, e = h[:-1], e[:-1]
    return h, e


def _fit(h: Floats, e: Floats) -> tuple[Order, float]:
    """The order, and the rms of ln(error) about the line."""
    from scipy.stats import t

    x, y = np.log(h), np.log(e)
    spread = x - x.mean()
    slope = float(spread @ y / (spread @ spread))
    rest = y - y.mean() - slope * spread
    free = len(h) - 2
    half = float(t.ppf(0.975, free) * np.sqrt(rest @ rest / free / (spread @ spread)))
    return Order(slope, half, float(h.max()), float(h.min()), len(h)), float(np.sqrt((rest**2).mean()))
