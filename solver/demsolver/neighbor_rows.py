"""Rows of pairs, made of who meets whom, and the memory of one list handed to the next.

Every pair stands in the row of its lower index, partners ascending: counted into rows, then each row sorted. With several threads each does a run of
rows, and writes no place of another's.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from demsolver.neighbor_grid import Codes, Images, Numbers
from demsolver.neighbor_search import Meetings
from demsolver.state import Floats, Ints, Pairs
from demsolver.threads import do, shares

# ruff: noqa: ANN001, ANN202

HOME = 13  # row of neighbors.SHIFTS that is (0, 0, 0)
PARTNER_FEELS = 32  # added to the code of an entry that the partner feels
CODE_BITS = 6  # of a key, below the partner
LOWEST_BIT = np.array([0, 0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0])  # of the numbers up to 15
SHORT = 16  # a row of which each entry is compared with all others
Unseen = tuple[NDArray[np.bool_], Numbers, Ints]  # of neighbors.exclusions


class Columns(NamedTuple):
    """Of the memory of a contact. law: how many columns belong to the law, the first ones. sign, source: (c,) what the other particle would have in
    a column is `sign` times what this one has in column `source`."""

    law: int
    sign: Floats
    source: Ints


def columns_of(signs: Floats, books: int = 0, geometry: int = 0) -> Columns:
    """signs: (m,) of the law's columns. books: columns of the energy budget behind them (kernel_contact.py), 0, 19 or 25: forces change their sign,
    torques their sides. geometry: of superquadrics behind those (kernel_shape.py), 0 or 7."""
    law = len(signs)
    sign = np.concatenate([signs, np.where(np.arange(books) < 6, -1.0, 1.0), np.where(np.arange(geometry) < 4, 1.0, -1.0)])
    source = np.arange(len(sign))
    for side in (6, 12, 19):
        if side < books:
            first, second = slice(law + side, law + side + 3), slice(law + side + 3, law + side + 6)
            source[first], source[second] = np.arange(len(sign))[second], np.arange(len(sign))[first]
    return Columns(law, sign, source)


class Runs(NamedTuple):
    """Pairs as they were found, in runs; two indices of 32 bits in one number.

    pairs: (p,). begin: (r + 1,) where runs begin; at their begin stand pairs at home, low and high index, up to home_end (r,), and at
    their end, from faces (r,) on, pairs of a particle and an image."""

    pairs: NDArray[np.uint64]
    begin: Ints
    home_end: Ints
    faces: Ints


def rows_of(n: int, columns: int, images: Images, meetings: list[Meetings], unseen: Unseen, *, periodic: bool, threads: int = 1) -> Pairs:
    """The list, `columns` zeros to remember for every entry. unseen: see neighbors.exclusions. meetings: emptied."""
    counts = np.zeros((threads, n), dtype=np.uint32)
    runs = _collected(n, images.owner, meetings, unseen, counts)
    meetings.clear()  # they take as much room as the list
    faces = int((runs.begin[1:] - runs.faces).sum())
    crossing, crossing_code = np.empty(2 * faces, dtype=np.uint64), np.empty(2 * faces, dtype=np.uint8)
    _mirror(n, images.owner, images.code, runs, crossing, crossing_code, counts[0])
    first, place = _cumulate(counts)
    m = int(first[-1])
    share = np.searchsorted(first, shares(m, threads))
    share[0], share[-1] = 0, n
    keys = np.empty(m, dtype=np.uint64)
    do(_scatter, _scatter_in_threads, share, runs, crossing, crossing_code, place, keys)
    del runs, crossing
    code, touching = np.empty(m if periodic else 0, dtype=np.uint8), np.empty(m, dtype=np.uint8)
    pairs = Pairs(first, np.empty(m, dtype=np.uint32), np.empty(m, dtype=np.uint32), code, touching, np.empty((m, columns)))
    do(_sort_rows, _sort_rows_in_threads, share, keys, pairs)
    return pairs


def _collected(n: int, owner: Numbers, meetings: list[Meetings], unseen: Unseen, counts: NDArray[np.uint32]) -> Runs:
    """counts: (t, n) of the pairs at home in each row, by who found them."""
    parts = [(found, part) for found in meetings for part in found.parts]
    threads = len(counts)
    begin = np.zeros(len(parts) * threads + 1, dtype=np.int64)
    for k, (_, part) in enumerate(parts):
        for t in range(threads):
            begin[k * threads + t + 1] = _count(part.lanes[t, : part.hits_of(t)])
    np.cumsum(begin, out=begin)
    runs = Runs(np.empty(begin[-1], dtype=np.uint64), begin, begin[:-1].copy(), begin[1:].copy())
    for k, (found, part) in enumerate(parts):
        points = n, owner, found.asking, found.asked
        do(_collect, _collect_in_threads, shares(threads, threads), k * threads, *points, part, *unseen, runs, counts)
    return runs


@njit(cache=True, error_model="numpy")
def _count(lanes):  # type: ignore[no-untyped-def]
    """How many bits there are."""
    m = 0
    for near in lanes:
        m += (near & 1) + (near >> 1 & 1) + (near >> 2 & 1) + (near >> 3)
    return m


@njit(error_model="numpy", forceinline=True)
def sieved(i, j, excluded, classes, clump):  # type: ignore[no-untyped-def]  # noqa: ANN201
    """Whether i and j do not see each other: by their classes, or as members of one clump."""
    return excluded[classes[i], classes[j]] or (len(clump) > 0 and clump[i] >= 0 and clump[i] == clump[j])


@njit(cache=True, error_model="numpy")
def _collect(t, _low, _high, before, n, owner, asking, asked, part, excluded, classes, clump, runs, counts):  # type: ignore[no-untyped-def]
    """Writes what thread t found as run before + t, and counts pairs at home."""
    begin, ends, hits, lanes = part.begin[t], part.ends[t], part.hits[t], part.lanes[t]
    pairs, count = runs.pairs, counts[t]
    home, faces = np.uint64(runs.home_end[before + t]), np.uint64(runs.faces[before + t])
    sieve = excluded.any() or len(clump) > 0
    k, one = np.uint64(0), np.uint64(1)
    for group in range(part.groups[t]):
        p = np.uint64(begin[group])
        for q in range(k, np.uint64(ends[group])):
            j, near = asked[hits[q]], np.uint64(lanes[q])
            while near:
                i = asking[p + np.uint64(LOWEST_BIT[near])]
                near &= near - one
                low, high = min(i, j), max(i, j)
                if high >= n:
                    if low < n and not (sieve and sieved(low, owner[high - n], excluded, classes, clump)):
                        faces -= one
                        pairs[faces] = _pair(low, high)
                elif not (sieve and sieved(low, high, excluded, classes, clump)):
                    pairs[home] = _pair(low, high)
                    count[low] += np.uint32(1)
                    home += one
        k = np.uint64(ends[group])
    runs.home_end[before + t], runs.faces[before + t] = home, faces


@njit(cache=True, error_model="numpy", parallel=True)
def _collect_in_threads(share, before, n, owner, asking, asked, part, excluded, classes, clump, runs, counts):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _collect(t, share[t], share[t + 1], before, n, owner, asking, asked, part, excluded, classes, clump, runs, counts)


@njit(error_model="numpy", forceinline=True)
def _pair(a, b):  # type: ignore[no-untyped-def]
    return np.uint64(a) << np.uint64(32) | np.uint64(b)


@njit(error_model="numpy", forceinline=True)
def _both(pair):  # type: ignore[no-untyped-def]
    return np.uint32(pair >> np.uint64(32)), np.uint32(pair & np.uint64(0xFFFFFFFF))


@njit(cache=True, error_model="numpy")
def _mirror(n, owner, shift, runs, pairs, code, count):  # type: ignore[no-untyped-def]
    """Writes the two entries of every pair of a particle and an image, as each of the two feels it, and counts them."""
    k = 0
    for r in range(len(runs.faces)):
        for q in range(runs.faces[r], runs.begin[r + 1]):
            i, image = _both(runs.pairs[q])
            j, s = owner[image - n], np.int64(shift[image - n])
            low, high = min(i, j), max(i, j)
            pairs[k] = pairs[k + 1] = _pair(low, high)
            code[k] = s + (PARTNER_FEELS if i > j else 0)
            code[k + 1] = 2 * HOME - s + (PARTNER_FEELS if j > i else 0)
            count[low] += np.uint32(2)
            k += 2


@njit(cache=True, error_model="numpy")
def _cumulate(counts):  # type: ignore[no-untyped-def]
    """first of state.Pairs, and the same once more for those who fill the rows."""
    n = counts.shape[1]
    first, place = np.empty(n + 1, dtype=np.int64), np.empty(n, dtype=np.uint32)
    m = np.int64(0)
    for i in range(n):
        first[i] = place[i] = m
        for t in range(counts.shape[0]):
            m += np.int64(counts[t, i])
    first[n] = m
    return first, place


@njit(cache=True, error_model="numpy")
def _scatter(t, low, high, runs, crossing, code, place, keys):  # type: ignore[no-untyped-def]
    """Puts the entries of rows low..high into their rows, in the order in which they were found."""
    low, high, one, bits = np.uint32(low), np.uint32(high), np.uint32(1), np.uint64(CODE_BITS)
    for r in range(len(runs.faces)):
        for q in range(np.uint64(runs.begin[r]), np.uint64(runs.home_end[r])):
            i, j = _both(runs.pairs[q])
            if low <= i < high:
                keys[place[i]] = np.uint64(j) << bits | np.uint64(HOME)
                place[i] += one
    for q in range(len(crossing)):
        i, j = _both(crossing[q])
        if low <= i < high:
            keys[place[i]] = np.uint64(j) << bits | np.uint64(code[q])
            place[i] += one


@njit(cache=True, error_model="numpy", parallel=True)
def _scatter_in_threads(share, runs, crossing, code, place, keys):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _scatter(t, share[t], share[t + 1], runs, crossing, code, place, keys)


@njit(cache=True, error_model="numpy")
def _sort_rows(t, low, high, keys, pairs):  # type: ignore[no-untyped-def]
    """Sorts the entries of rows low..high by partner, those of one pair by code, and writes them."""
    first, row, partner, code, touching, memory = pairs
    touching[first[low] : first[high]], memory[first[low] : first[high]] = 0, 0.0
    bits, mask, coded = np.uint64(CODE_BITS), np.uint64((1 << CODE_BITS) - 1), len(code) > 0
    for i in range(low, high):
        begin, end = np.uint64(first[i]), np.uint64(first[i + 1])
        long = end - begin > np.uint64(SHORT)
        if long:
            keys[begin:end].sort()
        for k in range(begin, end):
            key = keys[k]
            place = np.uint64(k) if long else begin
            if not long:  # which of two is the lower is hard to foretell: nothing here asks
                for q in range(begin, end):
                    place += np.uint64(keys[q] < key)
            row[place], partner[place] = i, key >> bits
            if coded:
                code[place] = key & mask


@njit(cache=True, error_model="numpy", parallel=True)
def _sort_rows_in_threads(share, keys, pairs):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _sort_rows(t, share[t], share[t + 1], keys, pairs)


class Remembered(NamedTuple):
    """Entries of a list that have something to remember, in its order. row, partner: (r,). code: (r,) or (0,). touching: (r,). memory: (r, c)."""

    row: Numbers
    partner: Numbers
    code: Codes
    touching: Codes
    memory: Floats


def remembered(pairs: Pairs, threads: int = 1) -> Remembered:
    """What of a list goes over to the next."""
    share, ends = shares(len(pairs.touching), threads), np.zeros(threads + 1, dtype=np.int64)
    do(_count_touching, _count_touching_in_threads, share, pairs.touching, ends)
    np.cumsum(ends, out=ends)
    r = int(ends[-1])
    code, columns = np.empty(r if len(pairs.code) else 0, dtype=np.uint8), pairs.memory.shape[1]
    kept = Remembered(np.empty(r, dtype=np.uint32), np.empty(r, dtype=np.uint32), code, np.empty(r, dtype=np.uint8), np.empty((r, columns)))
    do(_remember_touching, _remember_touching_in_threads, share, ends, pairs, kept)
    return kept


@njit(cache=True, error_model="numpy")
def _count_touching(t, low, high, touching, ends):  # type: ignore[no-untyped-def]
    """Writes how many of the entries low..high touch, or touched."""
    r = 0
    for k in range(low, high):
        r += touching[k] != 0
    ends[t + 1] = r


@njit(cache=True, error_model="numpy", parallel=True)
def _count_touching_in_threads(share, touching, ends):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _count_touching(t, share[t], share[t + 1], touching, ends)


@njit(cache=True, error_model="numpy")
def _remember_touching(t, low, high, ends, pairs, kept):  # type: ignore[no-untyped-def]
    """Writes those of the entries low..high that touch, or touched, from place ends[t] on."""
    q, coded, columns = np.uint64(ends[t]), len(pairs.code) > 0, pairs.memory.shape[1]
    for k in range(np.uint64(low), np.uint64(high)):
        if pairs.touching[k] != 0:
            kept.row[q], kept.partner[q], kept.touching[q] = pairs.row[k], pairs.partner[k], pairs.touching[k]
            if coded:
                kept.code[q] = pairs.code[k]
            for c in range(columns):
                kept.memory[q, c] = pairs.memory[k, c]
            q += np.uint64(1)


@njit(cache=True, error_model="numpy", parallel=True)
def _remember_touching_in_threads(share, ends, pairs, kept):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _remember_touching(t, share[t], share[t + 1], ends, pairs, kept)


def hand_over(threads: int, old: Remembered, *rest: Any) -> None:
    """Hands what is remembered of an old list to a new one: see neighbors.carry."""
    do(_hand_over, _hand_over_in_threads, shares(len(old.row), threads), old, *rest)


@njit(cache=True, error_model="numpy", parallel=True)
def _hand_over_in_threads(share, old, new, wraps, outlives, columns, x, radius, shifts, renumber):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _hand_over(t, share[t], share[t + 1], old, new, wraps, outlives, columns, x, radius, shifts, renumber)


@njit(cache=True, error_model="numpy")
def _hand_over(t, low, high, old, new, wraps, outlives, columns, x, radius, shifts, renumber):  # type: ignore[no-untyped-def]
    """The entries low..high of the old list; each has places of its own in the new one."""
    row, partner, codes, touching, memory = old
    to_first, _, to_partner, to_codes, to_touching, to_memory = new
    for k in range(low, high):
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
            _remember(memory, k, to_memory, q, columns, turned)
            if outlives and _apart(x, radius, i, j, shifts, moved):
                to_touching[q] &= 1
                to_memory[q, : columns.law] = 0.0


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
def _remember(memory, k, to_memory, q, columns, turned):  # type: ignore[no-untyped-def]
    """Memory of entry k to entry q; `turned`: as the other particle feels it."""
    for c in range(memory.shape[1]):
        to_memory[q, c] = columns.sign[c] * memory[k, columns.source[c]] if turned else memory[k, c]


@njit(error_model="numpy")
def turn(memory, which, columns):  # type: ignore[no-untyped-def]  # noqa: ANN201
    """Turns the memory of the entries `which` to how the other particle feels it, in place."""
    for k in which:
        was = memory[k : k + 1].copy()
        _remember(was, 0, memory, k, columns, True)


@njit(error_model="numpy", forceinline=True)
def _apart(x, radius, i, j, shifts, shift):  # type: ignore[no-untyped-def]
    """Whether two particles do not overlap."""
    square = 0.0
    for c in range(3):
        square += (x[i, c] - (x[j, c] + shifts[shift, c])) ** 2
    return square >= (radius[i] + radius[j]) ** 2
