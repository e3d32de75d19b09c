"""Which points stand within reach of each other.

A level meets itself with half a stencil, the rest of the own run of cells and the four rows of cells ahead, and what is smaller with a whole one
of nine rows. Points are visited in the order of the cells, so that the places where runs begin only ever advance. Points that follow one
another in a row look together, LANES at a time: what one of them has to look at, the others nearly always have to look at too.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from demsolver.neighbor_grid import LANES, Cells, Codes, Level, Numbers, Sorted
from demsolver.state import Ints

# ruff: noqa: ANN001, ANN202


class Part(NamedTuple):
    """Meetings found in one go. Group g of points, from begin[g] on, meets the points hits[ends[g - 1]:ends[g]].

    begin, ends: (groups,). hits: (m,). lanes: (m,) which of the group, bits."""

    begin: Numbers
    ends: Numbers
    hits: Numbers
    lanes: Codes


class Meetings(NamedTuple):
    """Who meets whom. asking: (p,) the points of the groups; asked: (q,) the points of the hits."""

    asking: Numbers
    asked: Numbers
    parts: list[Part]


def meetings_of(level: Level, skin: float) -> list[Meetings]:
    """Pairs of a level, and of its points with smaller ones; each once."""
    c, found = level.cells, []
    half = np.array([0, c.row, c.layer - c.row, c.layer, c.layer + c.row])
    found.append(_meetings(level.own, level.own, c, skin, c.fine, half))
    if level.finer:
        ahead = int(np.ceil((level.finer_largest + c.largest + skin) * c.inverse[0]))
        found.append(_meetings(level.finer, level.own, c, skin, ahead, np.concatenate([-half[:0:-1], half])))
    return found


def _meetings(asking: Sorted, asked: Sorted, cells: Cells, skin: float, ahead: int, offsets: Ints) -> Meetings:
    """Sweeps over all points, in as many parts as there is room for. ahead: cells along x that reach far enough."""
    parts: list[Part] = []
    front = np.zeros(len(offsets), dtype=np.uint64)
    points, start = len(asking.point), 0
    room = 4 * points + 64
    while start < points:
        groups = points - start
        part = Part(_numbers(groups), _numbers(groups), _numbers(room), np.empty(room, dtype=np.uint8))
        groups, stop = _sweep(asking, asked, asking.radius, asking is asked, cells.largest, skin, cells.fine, ahead, offsets, front, start, part)
        if stop == start:
            room *= 2
        else:
            m = part.ends[groups - 1]
            parts.append(Part(part.begin[:groups], part.ends[:groups], part.hits[:m], part.lanes[:m]))
        start = stop
    return Meetings(asking.point, asked.point, parts)


def _numbers(k: int) -> Numbers:
    return np.empty(k, dtype=np.uint32)


def _vector(context, xs, ys, zs, radii, x, y, z, radius, skin):  # type: ignore[no-untyped-def]
    """Bits of those of four points that are nearer to a fifth than both radii and the skin, all four in one vector."""
    signature = types.uint64(*[types.UniTuple(types.float64, LANES)] * 4, *[types.float64] * 5)  # type: ignore[no-untyped-call]

    def generate(_: Any, builder: ir.IRBuilder, __: Any, values: list[ir.Value]) -> ir.Value:
        def vector(lanes: list[ir.Value]) -> ir.Value:
            result = ir.Constant(ir.VectorType(ir.DoubleType(), LANES), ir.Undefined)
            for lane, value in enumerate(lanes):
                result = builder.insert_element(result, value, ir.IntType(32)(lane))
            return result

        *points, radii, x, y, z, radius, skin = values
        four = [vector([builder.extract_value(coordinates, lane) for lane in range(LANES)]) for coordinates in (*points, radii)]
        one = [vector(LANES * [value]) for value in (x, y, z, radius, skin)]
        dx, dy, dz = (builder.fsub(a, b) for a, b in zip(four[:3], one[:3], strict=True))
        square = builder.fadd(builder.fadd(builder.fmul(dx, dx), builder.fmul(dy, dy)), builder.fmul(dz, dz))
        reach = builder.fadd(builder.fadd(four[3], one[3]), one[4])
        bits = builder.bitcast(builder.fcmp_ordered("<", square, builder.fmul(reach, reach)), ir.IntType(LANES))
        return builder.zext(bits, ir.IntType(64))

    return signature, generate


_near: Any = intrinsic(_vector)


@njit(error_model="numpy", forceinline=True)
def _group(keys, fine, i):  # type: ignore[no-untyped-def]
    """How many points from i on look together: of one row, and each within reach of the next."""
    one = np.uint64(1)
    n = one
    while n < np.uint64(4) and keys[i + n] - fine <= keys[i + n - one]:
        n += one
    return n


@njit(error_model="numpy", forceinline=True)
def _four(values, i):  # type: ignore[no-untyped-def]
    return values[i], values[i + np.uint64(1)], values[i + np.uint64(2)], values[i + np.uint64(3)]


@njit(error_model="numpy", forceinline=True)
def _first(values, n, rest):  # type: ignore[no-untyped-def]
    """The first n of four values, and `rest` for the others."""
    two, three = np.uint64(2), np.uint64(3)
    return values[0], values[1] if n >= two else rest, values[2] if n >= three else rest, values[3] if n > three else rest


@njit(cache=True, error_model="numpy")
def _sweep(asking, asked, radius, itself, largest, skin, fine, ahead, offsets, front, start, part):  # type: ignore[no-untyped-def]
    """Runs of cells round the asking points from `start` on. offsets: of the keys of the runs; front: where they begin. No branch on the answer: it
    cannot be foretold. Returns how many groups there was room for, and the point behind the last."""
    keys, x, y, z = asked.keys, asked.x, asked.y, asked.z
    begin, ends, hits, lanes = part
    zero, one = np.uint64(0), np.uint64(1)
    points, room = np.uint64(len(asking.point)), np.uint64(len(hits))
    i, group, m = np.uint64(start), zero, zero
    rq = largest
    radii = rq, rq, rq, rq
    while i < points:
        n = _group(asking.keys, fine, i)
        xs, ys, zs = _first(_four(asking.x, i), n, np.inf), _four(asking.y, i), _four(asking.z, i)
        if radius is not None:
            radii = _four(radius, i)
        found = m
        if itself:
            for k in range(one, n):
                q = i + k
                if radius is not None:
                    rq = radius[q]
                near = _near(xs, ys, zs, radii, x[q], y[q], z[q], rq, skin) & ((one << k) - one)
                if found < room:
                    hits[found], lanes[found] = q, near
                found += np.uint64(near != zero)
            front[0] = i + n
        low, high = asking.keys[i] - ahead, asking.keys[i + n - one] + ahead
        for run in range(len(offsets)):
            q = front[run]
            while keys[q] < low + offsets[run]:
                q += one
            front[run] = q
            last = high + offsets[run]
            while keys[q] <= last:
                if radius is not None:
                    rq = asked.radius[q]
                near = _near(xs, ys, zs, radii, x[q], y[q], z[q], rq, skin)
                if found < room:
                    hits[found], lanes[found] = q, near
                found += np.uint64(near != zero)
                q += one
        if found > room:
            break
        begin[group], ends[group] = i, found
        m = found
        group += one
        i += n
    return np.int64(group), np.int64(i)
