"""Neighbour list: who can touch before the next list, and contact memory carried over.

A pair is listed when the centres are nearer than both radii plus the skin, and the gap that a contact of the two largest particles can bridge.
Cells are in neighbor_grid, the search is in neighbor_search, the rows of state.Pairs are in neighbor_rows; few particles need neither (neighbor_few).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from demsolver import neighbor_few, neighbor_rows, neighbor_search
from demsolver import neighbor_grid as cells
from demsolver.bind_law import longest_reach
from demsolver.neighbor_rows import HOME, PARTNER_FEELS, Columns, Remembered, Unseen, columns_of, remembered
from demsolver.scene import Scene
from demsolver.state import Bodies, Floats, Ints, Pairs, selected

__all__ = [
    "HOME", "PARTNER_FEELS", "SHIFTS", "Columns", "Unseen", "build", "carry", "columns_of", "empty_pairs", "exclusions", "frozen_remember",
    "morton_order",
    "remembered", "wrap",
]  # fmt: skip

SHIFTS: Ints = np.array([[a, b, c] for a in (-1, 0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1)])
Wraps = NDArray[np.int8]
FEW = 128
"""So many particles are looked at pair by pair: 8,000 pairs take a tenth of the time that cells need to be made."""
MORTON_BITS = 21  # of every axis, so that a code fits an int64


def empty_pairs(n: int, columns: int) -> Pairs:
    """A list without pairs."""
    none, empty = np.zeros(0, dtype=np.uint32), np.zeros(0, dtype=np.uint8)
    return Pairs(np.zeros(n + 1, dtype=np.int64), none, none.copy(), empty, empty.copy(), np.zeros((0, columns)))


def wrap(x: Floats, lo: Floats, hi: Floats, periodic: tuple[bool, bool, bool]) -> Wraps:
    """Moves particles back into the periodic box, in place; returns the wraps (n, 3): x_old = x_new + wraps * length."""
    wraps = np.zeros(x.shape, dtype=np.int8)
    for axis in range(3):
        if periodic[axis]:
            _wrap(x, axis, float(lo[axis]), float(hi[axis]), wraps)
    return wraps


@njit(cache=True, error_model="numpy")
def _wrap(x, axis, lo, hi, wraps):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """wrap along one axis."""
    for i in range(len(x)):
        if x[i, axis] < lo:
            x[i, axis] = max(x[i, axis] + (hi - lo), lo)
            wraps[i, axis] = -1
        elif x[i, axis] >= hi:
            x[i, axis] = max(x[i, axis] - (hi - lo), lo)
            wraps[i, axis] = 1


def build(scene: Scene, bodies: Bodies, lo: Floats, hi: Floats, columns: int, unseen: Unseen, threads: int = 1) -> Pairs:
    """Lists all pairs at the current positions; their memory is empty. lo, hi: (3,) of the box. unseen: as `exclusions` gives it. threads: how
    many search.

    Raises ValueError when a periodic box is shorter than the reach of a contact.
    """
    n, periodic = len(bodies.x), scene.box.periodic
    if n == 0:
        return empty_pairs(0, columns)
    largest = float(bodies.radius.max())
    skin = scene.neighbor.skin + (longest_reach(scene.pair, 0.5 * largest) if scene.pair else 0.0)
    _check_box(lo, hi, periodic, 2.0 * largest + skin)
    if n <= FEW and not any(periodic):
        return neighbor_few.few_rows(bodies.x, bodies.radius, skin, columns, unseen)
    images = cells.images_of(bodies.x, bodies.radius, skin, lo, hi, periodic)
    levels = cells.levels_of(bodies.x, images, bodies.radius, skin, threads)
    meetings = [found for level in levels for found in neighbor_search.meetings_of(level, skin, threads)]
    return neighbor_rows.rows_of(n, columns, images, meetings, unseen, periodic=any(periodic), threads=threads)


def _check_box(lo: Floats, hi: Floats, periodic: tuple[bool, bool, bool], reach: float) -> None:
    for axis in range(3):
        if periodic[axis] and hi[axis] - lo[axis] < reach:
            length = f"{hi[axis] - lo[axis]:g} long in {'xyz'[axis]}"
            message = f"the periodic box is {length}, shorter than the reach {reach:g} of a contact, skin included"
            raise ValueError(message)


def exclusions(scene: Scene, mask: Ints, kind: Ints, frozen: NDArray[np.bool_] | None = None, clump: Ints | None = None) -> Unseen:
    """A table (k, k) of classes of particles that do not see each other, the class of every particle, and the clump of each (-1: free), whose
    members do not see each other; (0,) where there are none. frozen: (n,) particles that do not see each other either."""
    group = {bit: selected(mask, bit) for rule in scene.neighbor.exclude for bit in rule}
    rules = [(group[a], group[b]) for a, b in scene.neighbor.exclude]
    rules += [(kind == a - 1, kind == b - 1) for a, b in scene.neighbor.exclude_types]
    rules += [] if frozen is None or not frozen.any() else [(frozen, frozen)]
    classes, samples = np.zeros(len(mask), dtype=np.uint32), np.zeros(1, dtype=np.int64)
    for a, b in rules:
        seen = np.full(4 * len(samples), -1, dtype=np.int64)
        samples = _split(a, b, classes, seen)
    table = np.zeros((len(samples), len(samples)), dtype=bool)
    for a, b in rules:
        table |= np.outer(a[samples], b[samples]) | np.outer(b[samples], a[samples])
    return table, classes, np.zeros(0, dtype=np.int64) if clump is None else clump


@njit(cache=True, error_model="numpy")
def _split(a, b, classes, seen):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Splits classes by two properties, in place; returns a particle of every class."""
    samples = np.empty(len(seen), dtype=np.int64)
    found = 0
    for i in range(len(classes)):
        pattern = 4 * classes[i] + 2 * a[i] + b[i]
        if seen[pattern] < 0:
            seen[pattern] = found
            samples[found] = i
            found += 1
        classes[i] = seen[pattern]
    return samples[:found].copy()


def frozen_remember(old: Remembered, b: Bodies) -> bool:
    """Whether contacts of two frozen particles remember something, which counts again when they are set free, or move and so begin to."""
    if not b.frozen.any():
        return False
    return bool(_frozen_meet(old.row, old.partner, b.frozen) or _frozen_move(b.frozen, b.v) or _frozen_move(b.frozen, b.omega))


@njit(cache=True, error_model="numpy")
def _frozen_meet(row, partner, frozen):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Whether both of any pair are frozen."""
    found = False
    for k in range(len(row)):
        found |= frozen[row[k]] & frozen[partner[k]]
    return found


@njit(cache=True, error_model="numpy")
def _frozen_move(frozen, v):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Whether any of the first particles, as many as there are velocities, is frozen and moves."""
    found = False
    for i in range(len(v)):
        found |= frozen[i] & ((v[i, 0] != 0.0) | (v[i, 1] != 0.0) | (v[i, 2] != 0.0))
    return found


def morton_order(x: Floats, lo: Floats, size: float) -> Ints:
    """(n,) which particles, one after another, sorts them by the Morton code of their cells; equal codes keep their order. x: (n, 3).
    lo: (3,) a lower corner. size: edge of a cell; longer where there would be more than 2 ** MORTON_BITS along an axis."""
    if not len(x):
        return np.zeros(0, dtype=np.int64)
    top = float((1 << MORTON_BITS) - 1)
    extent = min(float(np.max(cells.bounds_of(x)[1] - lo)), float(np.finfo(float).max))
    keys = np.empty(len(x) + 1, dtype=np.int64)
    span = _morton(x, lo, 1.0 / max(size, extent / top, cells.SMALLEST), top, keys) + 1
    return cells.sort(keys, np.arange(len(x), dtype=np.uint32), span)[1].astype(np.int64)


@njit(error_model="numpy")
def _spread(cell):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """The low 21 bits of a number with two empty bits behind each."""
    cell = (cell | cell << 32) & 0x1F00000000FFFF
    cell = (cell | cell << 16) & 0x1F0000FF0000FF
    cell = (cell | cell << 8) & 0x100F00F00F00F00F
    cell = (cell | cell << 4) & 0x10C30C30C30C30C3
    return (cell | cell << 2) & 0x1249249249249249


@njit(cache=True, error_model="numpy")
def _morton(x, lo, inverse, top, keys):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Writes the Morton codes; returns the largest."""
    largest = np.int64(0)
    for i in range(len(x)):
        code = np.int64(0)
        for axis in range(3):
            code |= _spread(np.int64(min(max((x[i, axis] - lo[axis]) * inverse, 0.0), top))) << axis
        keys[i] = code
        largest = max(largest, code)
    return largest


def carry(
    old: Remembered, new: Pairs, wraps: Wraps, outlives: bool, columns: Columns, bodies: Bodies, shifts: Floats, renumber: Ints, threads: int = 1
) -> None:
    """Hands what is remembered of the old list to the new one.

    wraps: (n, 3) periodic wraps since the old list, by old row. columns: of the memory.
    bodies, shifts: as they are now. renumber: (n,) where old row r now stands; (0,) if where it stood. threads: how many share the work.

    What touched at the last step goes over (LAMMPS). With `outlives`, what has touched since the last list goes over, but its
    tangential history only if the pair overlaps now (LIGGGHTS).
    """
    neighbor_rows.hand_over(threads, old, new, wraps, outlives, columns, bodies.x, bodies.radius, shifts, renumber)
