"""The arrays of the near list (kernel_near.py fills them)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from demsolver.state import Floats, Ints, Pairs
from demsolver.threads import do, shares


class Near(NamedTuple):
    """Pairs that can touch soon. Rows are cut into chunks; chunks: (c, 7), where its entries stand: FIRST, END of those with partners in the same
    chunk, CROSS_FIRST, CROSS_END of those with partners in later ones; KEPT_FIRST, KEPT_END of what several threads keep of those; APART: how
    many do not touch.

    Of an entry: row and partner; its code (as in Pairs); `entry`, its place in the list of all pairs, where what it remembers stands. listing:
    (m + 1,) scratch while the list is made. pushed: (n / 8,) whether a contact acts on any of eight rows. With several threads: share, cross_share
    (t + 1,): thread t does the chunks share[t] to share[t + 1], of the pairs between chunks cross_share[t] to cross_share[t + 1]; kept_row
    (x,), kept_action (x, 6 or 3): what these do to particles of another thread's chunks, force and torque. lanes, past, who: (t, ...) scratch of
    each thread, a block of contacts; lanes are float32 in mixed precision. scale: mean radius; bound of the way of any particle since
    the list of all pairs was built; how far a particle may depart from straight flight, over the mean radius.
    """

    chunks: Ints
    row: NDArray[np.uint32]
    partner: NDArray[np.uint32]
    entry: NDArray[np.uint32]
    listing: NDArray[np.uint32]
    code: NDArray[np.uint8]
    pushed: NDArray[np.uint8]
    kept_row: Ints
    kept_action: Floats
    share: Ints
    cross_share: Ints
    lanes: NDArray[np.floating]
    past: Floats
    who: NDArray[np.uint32]
    scale: Floats


# ruff: noqa: ANN001, ANN202

BLOCK = 64
"""Contacts whose arithmetic is done in one go: their fields stay in the fastest cache."""
START_LEEWAY = 3e-4
"""Of the mean radius, until the near list knows better."""
LINES = 128
"""Bytes that a core fetches together: two lines of its cache."""
FIELDS = 45
"""Of a contact in a block, beside its memory (kernel_contact.py names them)."""


def near_of(pairs: Pairs, scale: Floats, chunk: int, threads: int, *, turns: bool, mixed: bool) -> Near:
    """An empty near list with room for every pair. scale: as in Near, goes on from list to list. chunk: rows of a chunk. threads: 1, or how many
    share the chunks. turns: whether contacts make torques. mixed: whether geometry and forces of a contact are float32."""
    n, m = len(pairs.first) - 1, len(pairs.partner)
    count = max(1, -(-n // chunk))
    start = pairs.first[np.minimum(np.arange(count + 1) * min(chunk, n + 1), n)]
    crossing = np.zeros(count, dtype=np.int64)
    do(_crossing, _crossing_in_threads, shares(count, threads), pairs.first, pairs.partner, chunk, crossing)
    kept_first = np.cumsum(crossing) - crossing
    kept = int(crossing.sum()) if threads > 1 else 0
    first, cross_first = start[:-1], start[1:] - crossing
    return Near(
        chunks=np.column_stack([first, first, cross_first, cross_first, kept_first, kept_first, np.zeros_like(first)]),
        row=np.empty(m, dtype=np.uint32), partner=np.empty(m, dtype=np.uint32), entry=np.empty(m, dtype=np.uint32),
        listing=np.empty(m + 1, dtype=np.uint32),
        code=np.empty(len(pairs.code), dtype=np.uint8), pushed=np.zeros((n + 7) // 8, dtype=np.uint8),
        kept_row=np.empty(kept, dtype=np.int64), kept_action=np.empty((kept, 6 if turns else 3)),
        share=shares(count, threads), cross_share=shares(count, threads),
        lanes=_apart(threads, BLOCK * FIELDS, np.float32 if mixed else np.float64),
        past=_apart(threads, BLOCK * max(1, pairs.memory.shape[1]), np.float64), who=_apart(threads, 5 * BLOCK, np.uint32),
        scale=scale,
    )  # fmt: skip


def _apart(threads: int, m: int, kind: type[np.generic]) -> NDArray[Any]:
    """(t, ...) zeros, at least m of each thread, in cache lines of its own: where two threads write to one line, each waits for the other."""
    return np.zeros((threads, m + LINES // np.dtype(kind).itemsize), dtype=kind)


@njit(cache=True, error_model="numpy")
def _crossing(t, low, high, first, partner, chunk, found):  # type: ignore[no-untyped-def]
    """Writes how many pairs each of the chunks low..high of rows has with later ones."""
    for c in range(low, high):
        stop = min(len(first) - 1, (c + 1) * chunk)
        for k in range(first[c * chunk], first[stop]):
            found[c] += np.int64(partner[k] >= stop)


@njit(cache=True, error_model="numpy", parallel=True)
def _crossing_in_threads(share, first, partner, chunk, found):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _crossing(t, share[t], share[t + 1], first, partner, chunk, found)
