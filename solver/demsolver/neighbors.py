"""Neighbour list: particles and their periodic images into cells, cells into rows of pairs, contact memory carried over.

A pair stands in the row of its lower index; across a periodic face it stands in both rows, each with the image of the other. A pair is
listed when the centres are nearer than both radii plus the skin, and the gap that a contact of the two largest particles can bridge.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from demsolver.bind_law import longest_reach
from demsolver.scene import Scene
from demsolver.state import Bodies, Floats, Ints, Pairs, selected

SHIFTS: Ints = np.array([[a, b, c] for a in (-1, 0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1)])
HOME = 13  # row of SHIFTS that is (0, 0, 0)
MOST_CELLS = 1 << 20  # along an axis, so that a cell's number fits an int64


def empty_pairs(n: int, columns: int) -> Pairs:
    """A list without pairs."""
    return Pairs(
        first=np.zeros(n + 1, dtype=np.int64),
        partner=np.zeros(0, dtype=np.int64),
        shift=np.zeros(0, dtype=np.int64),
        touching=np.zeros(0, dtype=np.uint8),
        memory=np.zeros((0, columns)),
    )


def wrap(x: Floats, lo: Floats, hi: Floats, periodic: tuple[bool, bool, bool]) -> Ints:
    """Moves particles back into the periodic box, in place; returns the wraps (n, 3): x_old = x_new + wraps * length."""
    wraps = np.zeros(x.shape, dtype=np.int64)
    for axis in range(3):
        if periodic[axis]:
            length = hi[axis] - lo[axis]
            below, beyond = x[:, axis] < lo[axis], x[:, axis] >= hi[axis]
            x[below, axis] = np.maximum(x[below, axis] + length, lo[axis])
            x[beyond, axis] = np.maximum(x[beyond, axis] - length, lo[axis])
            wraps[below, axis] = -1
            wraps[beyond, axis] = 1
    return wraps


def build(scene: Scene, bodies: Bodies, box_lo: Floats, box_hi: Floats, columns: int) -> Pairs:
    """Lists all pairs of a scene at the current positions; their memory is empty.

    Raises ValueError when a periodic box is shorter than the reach of a contact.
    """
    n = len(bodies.x)
    if n == 0:
        return empty_pairs(0, columns)
    largest = float(bodies.radius.max())
    skin = scene.neighbor.skin + (longest_reach(scene.pair, 0.5 * largest) if scene.pair else 0.0)
    reach = 2.0 * largest + skin
    owner, shift = images(bodies.x, box_lo, box_hi, scene.box.periodic, reach)
    places = bodies.x[owner] + SHIFTS[shift] * (box_hi - box_lo)
    low = places.min(axis=0)
    size = max(reach, float(np.max(places.max(axis=0) - low)) / MOST_CELLS) * (1.0 + 1e-12)
    cell = ((places - low) / size).astype(np.int64) + 1
    keys = _key(cell[:, 0], cell[:, 1], cell[:, 2])
    order = np.argsort(keys, kind="stable")
    excluded, classes = exclusions(scene, bodies.mask, bodies.kind)
    sorted_owner = owner[order]
    first, partner, shifts = _rows(
        n, bodies.x, bodies.radius, cell, keys[order], places[order], sorted_owner, shift[order], bodies.radius[sorted_owner], skin, excluded,
        classes,
    )  # fmt: skip
    m = len(partner)
    return Pairs(first, partner, shifts, np.zeros(m, dtype=np.uint8), np.zeros((m, columns)))


def images(x: Floats, lo: Floats, hi: Floats, periodic: tuple[bool, bool, bool], reach: float) -> tuple[Ints, Ints]:
    """Owners and shift codes of all particles (first n: themselves) and of their images within `reach` of the box."""
    n = len(x)
    owner, code = np.arange(n), np.full(n, HOME)
    offset = np.zeros((n, 3), dtype=np.int64)
    for axis in range(3):
        if not periodic[axis]:
            continue
        length = hi[axis] - lo[axis]
        if length < reach:
            message = f"the periodic box is {length:g} long in {'xyz'[axis]}, shorter than the reach {reach:g} of a contact, skin included"
            raise ValueError(message)
        low = x[owner, axis] < lo[axis] + reach
        high = x[owner, axis] >= hi[axis] - reach
        step = np.zeros(3, dtype=np.int64)
        step[axis] = 1
        offset = np.concatenate([offset, offset[low] + step, offset[high] - step])
        owner = np.concatenate([owner, owner[low], owner[high]])
    code = ((offset[:, 0] + 1) * 3 + offset[:, 1] + 1) * 3 + offset[:, 2] + 1
    return owner, code


def exclusions(scene: Scene, mask: Ints, kind: Ints) -> tuple[NDArray[np.bool_], Ints]:
    """A table of classes of particles that do not see each other, and the class of every particle."""
    rules = [(selected(mask, a), selected(mask, b)) for a, b in scene.neighbor.exclude]
    rules += [(kind == a - 1, kind == b - 1) for a, b in scene.neighbor.exclude_types]
    if not rules:
        return np.zeros((1, 1), dtype=bool), np.zeros(len(mask), dtype=np.int64)
    code = sum(member.astype(np.int64) << bit for bit, member in enumerate(column for rule in rules for column in rule))
    patterns, classes = np.unique(code, return_inverse=True)
    table = np.zeros((len(patterns), len(patterns)), dtype=bool)
    for r in range(len(rules)):
        a, b = (patterns >> 2 * r) & 1 == 1, (patterns >> 2 * r + 1) & 1 == 1
        table |= np.outer(a, b) | np.outer(b, a)
    return table, classes.ravel()


@njit(error_model="numpy")
def _key(x, y, z):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """One number a cell; cells of a row along x follow one another."""
    return (z * (MOST_CELLS + 3) + y) * (MOST_CELLS + 3) + x


@njit(error_model="numpy")
def _first_from(keys, wanted):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """First position whose key is not below `wanted`."""
    low, high = 0, len(keys)
    while low < high:
        middle = (low + high) >> 1
        if keys[middle] < wanted:
            low = middle + 1
        else:
            high = middle
    return low


@njit(cache=True, error_model="numpy")
def _rows(n, x, radius, cell, keys, places, owner, shift, owner_radius, skin, excluded, classes):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Rows of pairs. keys, places, owner, shift, owner_radius: of particles and images in the order of their cells; only cells that
    hold something are stored, so that empty space costs nothing."""
    first = np.zeros(n + 1, dtype=np.int64)
    partner = np.empty(8 * n + 16, dtype=np.int64)
    code = np.empty(8 * n + 16, dtype=np.int64)
    sieve = excluded.shape[0] > 1
    m = 0
    for i in range(n):
        first[i] = m
        xi, yi, zi, ri = x[i, 0], x[i, 1], x[i, 2], radius[i] + skin
        for dz in range(-1, 2):
            for dy in range(-1, 2):
                last = _key(cell[i, 0] + 1, cell[i, 1] + dy, cell[i, 2] + dz)
                q = _first_from(keys, last - 2)
                while q < len(keys) and keys[q] <= last:
                    dx, ey, ez = xi - places[q, 0], yi - places[q, 1], zi - places[q, 2]
                    if dx * dx + ey * ey + ez * ez < (ri + owner_radius[q]) ** 2:
                        j = owner[q]
                        if not ((shift[q] == HOME and j <= i) or (sieve and excluded[classes[i], classes[j]])):
                            if m == len(partner):
                                partner = np.concatenate((partner, np.empty_like(partner)))
                                code = np.concatenate((code, np.empty_like(code)))
                            partner[m] = j
                            code[m] = shift[q]
                            m += 1
                    q += 1
    first[n] = m
    return first, partner[:m].copy(), code[:m].copy()


@njit(cache=True, error_model="numpy")
def carry(old: Any, new: Any, wraps: Ints, outlives: bool, signs: Floats, b: Any, shifts: Floats) -> None:
    """Hands the memory of the old list to the new one. `wraps` (n, 3): periodic wraps since the old list. `signs` (m,): of the columns of
    the law's memory when the particles change places.

    What touched at the last step goes over (LAMMPS). With `outlives`, what has touched since the last list goes over, but its
    tangential history only if the pair overlaps now (LIGGGHTS).
    """
    for i in range(len(old.first) - 1):
        for k in range(old.first[i], old.first[i + 1]):
            if old.touching[k]:
                j, code = old.partner[k], old.shift[k]
                a = code // 9 - 1 - wraps[i, 0] + wraps[j, 0]
                c = code // 3 % 3 - 1 - wraps[i, 1] + wraps[j, 1]
                d = code % 3 - 1 - wraps[i, 2] + wraps[j, 2]
                moved = ((a + 1) * 3 + c + 1) * 3 + d + 1
                _hand_over(old, k, new, i, j, moved, False, outlives, signs, b, shifts)
                if code == HOME and moved != HOME:
                    _hand_over(old, k, new, j, i, 26 - moved, True, outlives, signs, b, shifts)


@njit(error_model="numpy")
def _hand_over(old, k, new, i, j, code, turned, outlives, signs, b, shifts):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Memory of old pair k to the pair (i, j, code) of the new list; `turned`: as the partner felt it."""
    for q in range(new.first[i], new.first[i + 1]):
        if new.partner[q] != j or new.shift[q] != code:
            continue
        new.touching[q] = old.touching[k]
        base, columns = len(signs), old.memory.shape[1]
        for c in range(base):
            new.memory[q, c] = signs[c] * old.memory[k, c] if turned else old.memory[k, c]
        for c in range(base, columns):  # the budget's: forces change sign, torques change sides
            if turned:
                new.memory[q, c] = -old.memory[k, c] if c < base + 6 else old.memory[k, (c - base + 3) % 6 + c - (c - base) % 6]
            else:
                new.memory[q, c] = old.memory[k, c]
        if outlives:
            square = 0.0
            for c in range(3):
                square += (b.x[i, c] - (b.x[j, c] + shifts[code, c])) ** 2
            if square >= (b.radius[i] + b.radius[j]) ** 2:
                new.touching[q] &= 1
                for c in range(base):
                    new.memory[q, c] = 0.0
        return
