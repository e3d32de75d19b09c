"""Rows of pairs, made of who meets whom, and the memory of one list handed to the next.

Every pair stands in the row of its lower index, partners ascending: sorted by partner, then by row, both times by counting, so that a row as long as
the list costs no more than any other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from demsolver.neighbor_grid import Codes, Images, Numbers
from demsolver.neighbor_search import Meetings
from demsolver.state import Floats, Ints, Pairs

# ruff: noqa: ANN001, ANN202

HOME = 13  # row of neighbors.SHIFTS that is (0, 0, 0)
PARTNER_FEELS = 32  # added to the code of an entry that the partner feels
LOWEST_BIT = np.array([0, 0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0])  # of the numbers up to 15


def rows_of(
    n: int, images: Images, meetings: list[Meetings], classes: Numbers, excluded: NDArray[np.bool_], *, periodic: bool
) -> tuple[Ints, Numbers, Numbers, Codes]:
    """first, row, partner, code of state.Pairs. classes: (n,), of which those pairs are left out that `excluded` (k, k) names. meetings: emptied."""
    first, place = np.zeros(n + 1, dtype=np.int64), np.zeros(n + 1, dtype=np.uint32)
    pairs, home, faces = _collected(n, images.owner, meetings, classes, excluded, first, place)
    meetings.clear()  # they take as much room as the list
    crossing, crossing_code = np.empty(2 * faces, dtype=np.uint64), np.empty(2 * faces, dtype=np.uint8)
    _mirror(n, images.owner, images.code, pairs[len(pairs) - faces :], crossing, crossing_code, first, place)
    by_row = _cumulate(first, place)
    m = home + 2 * faces
    by_partner, by_partner_code = np.empty(m, dtype=np.uint64), _home_codes(m, periodic=periodic)
    _by_partner(pairs[:home], crossing, crossing_code, place, by_partner, by_partner_code)
    del pairs, crossing
    row, partner, code = np.empty(m, dtype=np.uint32), np.empty(m, dtype=np.uint32), _home_codes(m, periodic=periodic)
    _by_row(by_partner, by_partner_code, first, by_row, row, partner, code)
    return first, row, partner, code


def _collected(
    n: int, owner: Numbers, meetings: list[Meetings], classes: Numbers, excluded: NDArray[np.bool_], rows: Ints, partners: Numbers
) -> tuple[NDArray[np.uint64], int, int]:
    """Pairs, two indices of 32 bits in one number, and how many are at home and across faces: see _collect."""
    pairs = np.empty(sum(_count(part.lanes) for found in meetings for part in found.parts), dtype=np.uint64)
    home = faces = 0
    for found in meetings:
        for part in found.parts:
            home, faces = _collect(n, owner, found.asking, found.asked, part, classes, excluded, pairs, home, faces, rows, partners)
    return pairs, home, faces


def _home_codes(m: int, *, periodic: bool) -> Codes:
    return np.full(m if periodic else 0, HOME, dtype=np.uint8)


@njit(cache=True, error_model="numpy")
def _count(lanes):  # type: ignore[no-untyped-def]
    """How many bits there are."""
    m = 0
    for near in lanes:
        m += (near & 1) + (near >> 1 & 1) + (near >> 2 & 1) + (near >> 3)
    return m


@njit(cache=True, error_model="numpy")
def _collect(n, owner, asking, asked, part, classes, excluded, pairs, home, faces, rows, partners):  # type: ignore[no-untyped-def]
    """Appends pairs of particles, low and high index, at the front and counts them in rows[low + 1] and partners[high + 1]; pairs of a particle
    and an image, in this order, at the back. Returns how many there are of both."""
    begin, ends, hits, lanes = part
    sieve = excluded.any()
    k, one = np.uint64(0), np.uint64(1)
    for group in range(len(ends)):
        p = np.uint64(begin[group])
        for q in range(k, np.uint64(ends[group])):
            j, near = asked[hits[q]], np.uint64(lanes[q])
            while near:
                i = asking[p + np.uint64(LOWEST_BIT[near])]
                near &= near - one
                low, high = min(i, j), max(i, j)
                if high >= n:
                    if low < n and not (sieve and excluded[classes[low], classes[owner[high - n]]]):
                        faces += 1
                        pairs[len(pairs) - faces] = _pair(low, high)
                elif not (sieve and excluded[classes[low], classes[high]]):
                    pairs[home] = _pair(low, high)
                    rows[low + one] += 1
                    partners[high + one] += np.uint32(1)
                    home += 1
        k = np.uint64(ends[group])
    return home, faces


@njit(error_model="numpy", forceinline=True)
def _pair(a, b):  # type: ignore[no-untyped-def]
    return np.uint64(a) << np.uint64(32) | np.uint64(b)


@njit(error_model="numpy", forceinline=True)
def _both(pair):  # type: ignore[no-untyped-def]
    return np.uint32(pair >> np.uint64(32)), np.uint32(pair & np.uint64(0xFFFFFFFF))


@njit(cache=True, error_model="numpy")
def _mirror(n, owner, shift, faces, pairs, code, rows, partners):  # type: ignore[no-untyped-def]
    """Writes the two entries of every pair of a particle and an image, as each of the two feels it, and counts them."""
    for k in range(len(faces)):
        i, image = _both(faces[k])
        j, s = owner[image - n], np.int64(shift[image - n])
        low, high = min(i, j), max(i, j)
        pairs[2 * k] = pairs[2 * k + 1] = _pair(low, high)
        code[2 * k] = s + (PARTNER_FEELS if i > j else 0)
        code[2 * k + 1] = 2 * HOME - s + (PARTNER_FEELS if j > i else 0)
        rows[low + 1] += 2
        partners[high + 1] += np.uint32(2)


@njit(cache=True, error_model="numpy")
def _cumulate(rows, partners):  # type: ignore[no-untyped-def]
    """Counts to first places, in place; returns those of the rows once more."""
    places = np.empty(len(rows) - 1, dtype=np.uint32)
    for i in range(len(places)):
        places[i] = rows[i]
        rows[i + 1] += rows[i]
        partners[i + 1] += partners[i]
    return places


@njit(cache=True, error_model="numpy")
def _by_partner(home, crossing, crossing_code, place, pairs, code):  # type: ignore[no-untyped-def]
    """Sorts entries by partner, those across faces behind the others."""
    for pair in home:
        j = _both(pair)[1]
        pairs[place[j]] = pair
        place[j] += np.uint32(1)
    for k in range(len(crossing)):
        j = _both(crossing[k])[1]
        pairs[place[j]], code[place[j]] = crossing[k], crossing_code[k]
        place[j] += np.uint32(1)


@njit(cache=True, error_model="numpy")
def _by_row(pairs, code, first, place, row, partner, to_code):  # type: ignore[no-untyped-def]
    """Sorts entries by row; entries of one pair, which follow one another, by code."""
    for k in range(len(pairs)):
        i, j = _both(pairs[k])
        q = place[i]
        place[i] = q + np.uint32(1)
        row[q], partner[q] = i, j
        if len(code) and code[k] != HOME:
            while q > first[i] and partner[q - 1] == j and to_code[q - 1] > code[k]:
                to_code[q] = to_code[q - 1]
                q -= 1
            to_code[q] = code[k]


class Remembered(NamedTuple):
    """Entries of a list that have something to remember, in its order. row, partner: (r,). code: (r,) or (0,). touching: (r,). memory: (r, c)."""

    row: Numbers
    partner: Numbers
    code: Codes
    touching: Codes
    memory: Floats


def remembered(pairs: Pairs) -> Remembered:
    """What of a list goes over to the next."""
    k = np.flatnonzero(pairs.touching != 0)
    code = pairs.code.take(k) if len(pairs.code) else pairs.code
    return Remembered(pairs.row.take(k), pairs.partner.take(k), code, pairs.touching.take(k), pairs.memory.take(k, axis=0))


@njit(cache=True, error_model="numpy")
def hand_over(old, new, wraps, outlives, signs, x, radius, shifts, renumber) -> None:  # type: ignore[no-untyped-def]
    """Hands what is remembered of an old list to a new one: see neighbors.carry."""
    row, partner, codes, touching, memory = old
    to_first, _, to_partner, to_codes, to_touching, to_memory = new
    for k in range(len(row)):
        code = int(codes[k]) if len(codes) else HOME
        shift = code % PARTNER_FEELS
        acts, other = np.int64(row[k]), np.int64(partner[k])
        if code >= PARTNER_FEELS:
            acts, other = other, acts
        moved = shift
        a, b, c = wraps[other, 0] - wraps[acts, 0], wraps[other, 1] - wraps[acts, 1], wraps[other, 2] - wraps[acts, 2]
        if a | b | c:
            a, b, c = a + shift // 9, b + shift // 3 % 3, c + shift % 3
            if min(a, b, c) < 0 or max(a, b, c) > 2:
                continue
            moved = (a * 3 + b) * 3 + c
        i, j = (renumber[acts], renumber[other]) if len(renumber) else (acts, other)
        for turned in range(2 if shift == HOME else 1):  # across a face both have an entry; at home one has, the lower index's
            if turned:
                i, j, moved = j, i, 2 * HOME - moved
            if moved == HOME and i > j:
                continue
            q = _entry(to_first, to_partner, to_codes, i, j, moved)
            if q < 0:
                continue
            to_touching[q] = touching[k]
            _remember(memory, k, to_memory, q, signs, turned)
            if outlives and _apart(x, radius, i, j, shifts, moved):
                to_touching[q] &= 1
                to_memory[q, : len(signs)] = 0.0


@njit(error_model="numpy", forceinline=True)
def _entry(first, partner, codes, acts, other, shift):  # type: ignore[no-untyped-def]
    """Place in a list of what `acts` feels of the image of `other`, -1 if it is not listed."""
    coded = len(codes) > 0
    if not coded and shift != HOME:
        return -1
    row, column = min(acts, other), max(acts, other)
    code = shift + (PARTNER_FEELS if acts > other else 0)
    low, high = first[row], first[row + 1]
    while low < high:
        middle = (low + high) >> 1
        if partner[middle] < column or (coded and partner[middle] == column and codes[middle] < code):
            low = middle + 1
        else:
            high = middle
    return low if low < first[row + 1] and partner[low] == column and (not coded or codes[low] == code) else -1


@njit(error_model="numpy", forceinline=True)
def _remember(memory, k, to_memory, q, signs, turned):  # type: ignore[no-untyped-def]
    """Memory of entry k to entry q; `turned`: as the other particle feels it. Of the budget's columns forces change sign, torques change sides."""
    base = len(signs)
    for c in range(memory.shape[1]):
        if not turned:
            to_memory[q, c] = memory[k, c]
        elif c < base:
            to_memory[q, c] = signs[c] * memory[k, c]
        elif c < base + 6:
            to_memory[q, c] = -memory[k, c]
        elif c < base + 18:
            to_memory[q, c] = memory[k, c + 3 if (c - base) % 6 < 3 else c - 3]
        else:
            to_memory[q, c] = memory[k, c]


@njit(error_model="numpy", forceinline=True)
def _apart(x, radius, i, j, shifts, shift):  # type: ignore[no-untyped-def]
    """Whether two particles do not overlap."""
    square = 0.0
    for c in range(3):
        square += (x[i, c] - (x[j, c] + shifts[shift, c])) ** 2
    return square >= (radius[i] + radius[j]) ** 2
