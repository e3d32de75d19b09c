"""The neighbour list as those outside the loop see it, and without the particles that are gone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from demsolver.neighbors import HOME, PARTNER_FEELS
from demsolver.state import Floats, Ints, Pairs


class Listed(NamedTuple):
    """The pairs of a list one by one, all arrays (m,): particle `i` feels the image of `j` shifted by row `shift` of SHIFTS. A pair without a
    face between is listed once and felt by both. memory: (m, c), as i feels it."""

    i: Ints
    j: Ints
    shift: Ints
    touching: NDArray[np.uint8]
    memory: Floats


def listed(pairs: Pairs, order: Ints) -> Listed:
    """A neighbour list pair by pair; order: (n,) number of the particle in each row."""
    row, partner = order[pairs.row], order[pairs.partner]
    code = pairs.code.astype(np.int64) if len(pairs.code) else np.full(len(row), HOME)
    turned = code >= PARTNER_FEELS
    i, j = np.where(turned, partner, row), np.where(turned, row, partner)
    return Listed(i, j, code - PARTNER_FEELS * turned, pairs.touching.copy(), pairs.memory.copy())


def without(pairs: Pairs, keep: NDArray[np.bool_]) -> Pairs:
    """The list without the particles that are gone, rows renumbered. keep: (n,)."""
    number = np.cumsum(keep) - 1
    kept = keep[pairs.row] & keep[pairs.partner]
    row, partner = (number[rows[kept]].astype(np.uint32) for rows in (pairs.row, pairs.partner))
    counts = np.bincount(row, minlength=int(keep.sum()))
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    code = pairs.code[kept] if len(pairs.code) else pairs.code
    return Pairs(first, row, partner, code, pairs.touching[kept], np.ascontiguousarray(pairs.memory[kept]))
