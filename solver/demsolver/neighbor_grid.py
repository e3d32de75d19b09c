"""Particles in cells: one grid for every level of size, and the images behind periodic faces.

A grid holds what there is in the order of the cells, and nothing for empty space. Cells are numbered along x first, and are cut finer along
x than along y and z: what lies within reach in a row of cells is one run of neighbours in this order.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from demsolver.state import Floats, Ints
from demsolver.threads import do, shares

# ruff: noqa: ANN001, ANN202

Numbers = NDArray[np.uint32]
Codes = NDArray[np.uint8]
MOST_CELLS = 1 << 20  # along an axis, and four times as many along x, so that the number of a cell fits an int64
FINEST = 16  # cells along x to a reach: finer saves no more tests
SLACK = 1e-6  # of a cell; rounding is MOST_CELLS roundings, 1e-9
SMALLEST = 1e-280  # edge of a cell whose inverse is still a number
LEVELS = 10  # sizes by a factor of 4: coarser steps test more pairs, finer ones sort more often
DIGIT = 11  # bits sorted by in one pass: as many counters as the nearest cache holds
LANES = 4  # points that look for others at a time (see neighbor_search)
BEYOND = np.iinfo(np.int64).max  # a key behind all others


class Images(NamedTuple):
    """Images of particles behind periodic faces. place: (g, 3). owner: (g,) the particle. code: (g,) row of SHIFTS."""

    place: Floats
    owner: Numbers
    code: Codes


class Cells(NamedTuple):
    """How space is cut for one level of size. low: (3,) corner. inverse: (3,) of the edges of a cell. number: (3,) of the cells that may hold
    something; behind them a row has `fine` empty ones, and a layer an empty row, so that runs of different rows do not meet. fine: cells along x
    to a reach. largest: radius of the level."""

    low: Floats
    inverse: Floats
    number: Ints
    fine: int
    largest: float

    @property
    def row(self) -> int:
        """Difference of the keys of a cell and the next along y."""
        return int(self.number[0]) + self.fine

    @property
    def layer(self) -> int:
        """Difference of the keys of a cell and the next along z."""
        return (int(self.number[1]) + 1) * self.row


class Sorted(NamedTuple):
    """Points in the order of their cells: particles i < n, and images n + g.

    keys: (p + 1,) numbers of the cells, then BEYOND. point: (p,). x, y, z: (p + LANES - 1,), infinite behind the last point. radius: the same, or
    None when all are alike."""

    keys: Ints
    point: Numbers
    x: Floats
    y: Floats
    z: Floats
    radius: Floats | None


class Level(NamedTuple):
    """Points of about one size, and in the same cells those that are smaller, if there are any: largest of them has radius `finer_largest`."""

    cells: Cells
    own: Sorted
    finer: Sorted | None
    finer_largest: float


def levels_of(x: Floats, images: Images, radius: Floats, skin: float, threads: int = 1) -> Iterator[Level]:
    """All points, the largest first. x: (n, 3), n > 0. radius: (n,)."""
    bounds = bounds_of(x, images.place)
    alike = bool(radius.min() == radius.max())
    if alike:
        parts, largest = [np.arange(len(x) + len(images.owner), dtype=np.uint32)], [float(radius[0])]
    else:
        parts = _by_size(radius, images, skin)
        largest = [float(radius[part[part < len(x)]].max()) for part in parts]
    for k, part in enumerate(parts):
        cells = _cells(bounds, skin, largest[k])
        own = _sorted(cells, x, images, radius, part, alike=alike, threads=threads)
        if k + 1 == len(parts):
            yield Level(cells, own, None, 0.0)
        else:
            finer = np.concatenate(parts[k + 1 :])
            yield Level(cells, own, _sorted(cells, x, images, radius, finer, alike=alike, threads=threads), largest[k + 1])


def bounds_of(*places: Floats) -> Floats:
    """(2, 3) lowest and highest coordinates of all places."""
    bounds = np.array([[np.inf] * 3, [-np.inf] * 3])
    for part in places:
        _bounds(part, bounds)
    return bounds


def _cells(bounds: Floats, skin: float, largest: float) -> Cells:
    """Cells as long as the reach of the largest two. bounds: (2, 3)."""
    with np.errstate(over="ignore"):
        extent = np.minimum(bounds[1] - bounds[0], np.finfo(float).max)
    edge = max(2.0 * largest + skin, float(extent.max()) / MOST_CELLS, SMALLEST) * (1.0 + SLACK)
    fine = int(min(FINEST, 4.0 * MOST_CELLS / (extent[0] / edge + 1.0)))
    inverse = np.array([fine, 1.0, 1.0]) / edge
    return Cells(bounds[0], inverse, (extent * inverse).astype(np.int64) + 1, fine, largest)


def _sorted(cells: Cells, x: Floats, images: Images, radius: Floats, members: Numbers, *, alike: bool, threads: int) -> Sorted:
    """Members in the order of their cells."""
    p, more = len(members), len(members) + LANES - 1
    share, keys = shares(p, threads), np.empty(p + 1, dtype=np.int64)
    do(_number, _number_in_threads, share, x, images.place, members, *cells[:4], keys)
    keys, members = sort(keys, members, int(cells.number[2]) * cells.layer, threads)
    found = Sorted(keys, members, np.empty(more), np.empty(more), np.empty(more), None if alike else np.empty(more))
    do(_gather, _gather_in_threads, share, x, images.place, images.owner, radius, members, *found[2:])
    for values in found[2:5]:
        values[p:] = np.inf
    if found.radius is not None:
        found.radius[p:] = 0.0
    return found


def sort(keys: Ints, members: Numbers, span: int, threads: int = 1) -> tuple[Ints, Numbers]:
    """Sorts (p,) members by their keys in 0 .. span - 1, equal keys in the order they are in. keys: (p + 1,), overwritten. Returns keys, (p + 1,)
    with BEYOND at the end, and members."""
    bits = max(1, (span - 1).bit_length())
    passes = -(-bits // DIGIT)
    width = -(-bits // passes)
    share, counts = shares(len(members), threads), np.empty((threads, 1 << width), dtype=np.uint32)
    to_keys, to_members, spare = np.empty_like(keys), np.empty_like(members), np.empty_like(members)
    for k in range(passes):
        do(_count_digits, _count_digits_in_threads, share, keys, k * width, counts)
        _cumulate(counts)
        do(_sort_by_digit, _sort_by_digit_in_threads, share, keys, members, counts, k * width, to_keys, to_members)
        keys, to_keys = to_keys, keys
        members, to_members = to_members, spare if k == 0 else members
    keys[-1] = BEYOND
    return keys, members


def _by_size(radius: Floats, images: Images, skin: float) -> list[Numbers]:
    """Points by size: what reaches more than a quarter as far as the largest, then more than a quarter of that, and so on; none is empty."""
    reach = radius + 0.5 * skin
    ratio = reach.max() / np.maximum(reach, 4.0**-LEVELS * reach.max())
    size = np.minimum((np.frexp(ratio)[1] - 1) // 2, LEVELS - 1).astype(np.int64)
    size = np.concatenate([size, size[images.owner]])
    points = sort(np.append(size, 0), np.arange(len(size), dtype=np.uint32), LEVELS)[1]
    return [part for part in np.split(points, np.cumsum(np.bincount(size))) if len(part)]


def images_of(x: Floats, radius: Floats, skin: float, lo: Floats, hi: Floats, periodic: tuple[bool, bool, bool]) -> Images:
    """The images that a particle may meet behind periodic faces; of two opposite shifts the one later in SHIFTS, so that a pair meets once across
    a face."""
    margin = float(radius.max()) + skin + 1e-12 * float(np.max(np.abs([lo, hi])))
    faces = tuple(np.where(periodic, lo, -np.inf).tolist()), tuple(np.where(periodic, hi, np.inf).tolist())
    near = np.empty(len(x) if any(periodic) else 0, dtype=np.uint32)
    near = near[: _near_low_faces(x, radius, margin, faces[0], near)]
    found = 0
    for _ in range(2):  # counts, then writes
        images = Images(np.empty((found, 3)), np.empty(found, dtype=np.uint32), np.empty(found, dtype=np.uint8))
        found = _images(x, radius, margin, *faces, near, *images)
    return images


@njit(cache=True, error_model="numpy")
def _bounds(place, bounds):  # type: ignore[no-untyped-def]
    """Moves bounds (2, 3) apart until all places are within."""
    low_x, low_y, low_z = bounds[0, 0], bounds[0, 1], bounds[0, 2]
    high_x, high_y, high_z = bounds[1, 0], bounds[1, 1], bounds[1, 2]
    for i in range(len(place)):
        x, y, z = place[i, 0], place[i, 1], place[i, 2]
        low_x, low_y, low_z = min(low_x, x), min(low_y, y), min(low_z, z)
        high_x, high_y, high_z = max(high_x, x), max(high_y, y), max(high_z, z)
    bounds[0, 0], bounds[0, 1], bounds[0, 2] = low_x, low_y, low_z
    bounds[1, 0], bounds[1, 1], bounds[1, 2] = high_x, high_y, high_z


@njit(cache=True, error_model="numpy")
def _number(t, first, last, x, images, members, low, inverse, number, fine, keys):  # type: ignore[no-untyped-def]
    """Writes the number of the cell of each of the members first..last."""
    n, row, rows = len(x), number[0] + fine, number[1] + 1
    low_x, low_y, low_z = low[0], low[1], low[2]
    per_x, per_y, per_z = inverse[0], inverse[1], inverse[2]
    top_x, top_y, top_z = number[0] - 1.0, number[1] - 1.0, number[2] - 1.0
    for k in range(np.uint64(first), np.uint64(last)):
        p = members[k]
        px, py, pz = (x[p, 0], x[p, 1], x[p, 2]) if p < n else (images[p - n, 0], images[p - n, 1], images[p - n, 2])
        a, b, c = min((px - low_x) * per_x, top_x), min((py - low_y) * per_y, top_y), min((pz - low_z) * per_z, top_z)
        keys[k] = (np.int64(c) * rows + np.int64(b)) * row + np.int64(a)


@njit(cache=True, error_model="numpy", parallel=True)
def _number_in_threads(share, x, images, members, low, inverse, number, fine, keys):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _number(t, share[t], share[t + 1], x, images, members, low, inverse, number, fine, keys)


@njit(cache=True, error_model="numpy")
def _count_digits(t, first, last, keys, shift, counts):  # type: ignore[no-untyped-def]
    """Counts the digits of the keys first..last; a digit has as many values as there are counters."""
    count, mask = counts[t], counts.shape[1] - 1
    count[:] = 0
    for p in range(np.uint64(first), np.uint64(last)):
        count[(keys[p] >> shift) & mask] += np.uint32(1)


@njit(cache=True, error_model="numpy", parallel=True)
def _count_digits_in_threads(share, keys, shift, counts):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _count_digits(t, share[t], share[t + 1], keys, shift, counts)


@njit(cache=True, error_model="numpy")
def _cumulate(counts):  # type: ignore[no-untyped-def]
    """Where the keys of each digit go, those of each thread behind those of the thread before; in place of how many there are."""
    begin = np.uint32(0)
    for d in range(counts.shape[1]):
        for t in range(counts.shape[0]):
            counts[t, d], begin = begin, begin + counts[t, d]


@njit(cache=True, error_model="numpy")
def _sort_by_digit(t, first, last, keys, members, counts, shift, to_keys, to_members):  # type: ignore[no-untyped-def]
    """One pass of a radix sort, over the keys first..last; counts: see _cumulate, overwritten."""
    place, mask = counts[t], counts.shape[1] - 1
    for p in range(np.uint64(first), np.uint64(last)):
        digit = (keys[p] >> shift) & mask
        to = place[digit]
        place[digit] = to + np.uint32(1)
        to_keys[to], to_members[to] = keys[p], members[p]


@njit(cache=True, error_model="numpy", parallel=True)
def _sort_by_digit_in_threads(share, keys, members, counts, shift, to_keys, to_members):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _sort_by_digit(t, share[t], share[t + 1], keys, members, counts, shift, to_keys, to_members)


@njit(cache=True, error_model="numpy")
def _gather(t, first, last, x, images, owner, radii, members, to_x, to_y, to_z, to_radius):  # type: ignore[no-untyped-def]
    """Writes what belongs to the members first..last in their order."""
    n = len(x)
    for k in range(np.uint64(first), np.uint64(last)):
        p = members[k]
        to_x[k], to_y[k], to_z[k] = (x[p, 0], x[p, 1], x[p, 2]) if p < n else (images[p - n, 0], images[p - n, 1], images[p - n, 2])
        if to_radius is not None:
            to_radius[k] = radii[p if p < n else owner[p - n]]


@njit(cache=True, error_model="numpy", parallel=True)
def _gather_in_threads(share, x, images, owner, radii, members, to_x, to_y, to_z, to_radius):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _gather(t, share[t], share[t + 1], x, images, owner, radii, members, to_x, to_y, to_z, to_radius)


@njit(cache=True, error_model="numpy")
def _near_low_faces(x, radius, margin, lo, near):  # type: ignore[no-untyped-def]
    """Writes who of the first particles, as many as `near` is long, stands within its reach of a lower face; returns how many."""
    found = np.uint64(0)
    for i in range(len(near)):
        reach = radius[i] + margin
        near[found] = i
        found += np.uint64((x[i, 0] < lo[0] + reach) | (x[i, 1] < lo[1] + reach) | (x[i, 2] < lo[2] + reach))
    return np.int64(found)


@njit(cache=True, error_model="numpy")
def _images(x, radius, margin, lo, hi, near, place, owner, code):  # type: ignore[no-untyped-def]
    """Writes the images, as many as there is room for; returns how many there are. lo, hi: infinite where nothing is periodic."""
    found = 0
    for i in near:
        reach = radius[i] + margin
        for a in range(2):
            if a == 1 and not x[i, 0] < lo[0] + reach:
                continue
            for b in range(-a, 2):
                if (b == 1 and not x[i, 1] < lo[1] + reach) or (b == -1 and not x[i, 1] >= hi[1] - reach):
                    continue
                for c in range(-1 if a or b else 1, 2):
                    if (c == 1 and not x[i, 2] < lo[2] + reach) or (c == -1 and not x[i, 2] >= hi[2] - reach):
                        continue
                    if found < len(owner):
                        place[found, 0] = x[i, 0] + a * (hi[0] - lo[0]) if a else x[i, 0]
                        place[found, 1] = x[i, 1] + b * (hi[1] - lo[1]) if b else x[i, 1]
                        place[found, 2] = x[i, 2] + c * (hi[2] - lo[2]) if c else x[i, 2]
                        owner[found] = i
                        code[found] = ((a + 1) * 3 + b + 1) * 3 + c + 1
                    found += 1
    return found
