"""The neighbour list of few particles: every pair is looked at."""

from __future__ import annotations

import numpy as np
from numba import njit

from demsolver.neighbor_rows import Unseen, sieved
from demsolver.state import Floats, Pairs

# ruff: noqa: ANN001, ANN202


def few_rows(x: Floats, radius: Floats, skin: float, columns: int, unseen: Unseen) -> Pairs:
    """The list of few particles without periodic faces, by looking at every pair: the same, where cells would take longer to make than to search."""
    n = len(x)
    first, room = np.zeros(n + 1, dtype=np.int64), n * (n - 1) // 2
    row, partner = np.empty(room, dtype=np.uint32), np.empty(room, dtype=np.uint32)
    m = _few(x, radius, skin, *unseen, first, row, partner)
    none = np.zeros(0, dtype=np.uint8)
    return Pairs(first, row[:m].copy(), partner[:m].copy(), none, np.zeros(m, dtype=np.uint8), np.zeros((m, columns)))


@njit(cache=True, error_model="numpy")
def _few(x, radius, skin, excluded, classes, clump, first, row, partner):  # type: ignore[no-untyped-def]
    """Writes the pairs, and where each row begins; returns how many there are."""
    m = 0
    for i in range(len(x)):
        for j in range(i + 1, len(x)):
            dx, dy, dz = x[i, 0] - x[j, 0], x[i, 1] - x[j, 1], x[i, 2] - x[j, 2]
            reach = radius[i] + radius[j] + skin
            if dx * dx + dy * dy + dz * dz < reach * reach and not sieved(i, j, excluded, classes, clump):
                row[m], partner[m] = i, j
                m += 1
        first[i + 1] = m
    return m
