"""Which points stand within reach of each other.

A level meets itself with half a stencil, the rest of the own run of cells and the four rows of cells ahead, and what is smaller with a whole one
of nine rows. Points are visited in the order of the cells, so that the places where runs begin only ever advance. Points that follow one
another in a row look together, LANES at a time: what one of them has to look at, the others nearly always have to look at too.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import njit, prange, types
from numba.extending import intrinsic

from demsolver.neighbor_grid import LANES, Cells, Codes, Level, Numbers, Sorted
from demsolver.state import Ints
from demsolver.threads import do, shares

# ruff: noqa: ANN001, ANN202


class Part(NamedTuple):
    """Meetings found in one go, by each of t threads. Group g of points of thread t, from begin[t, g] on, meets the points
    hits[t, ends[t, g - 1]:ends[t, g]].

    groups: (t,) how many. begin, ends: (t, g). hits: (t, m). lanes: (t, m) which of the group, bits."""

    groups: Ints
    begin: Numbers
    ends: Numbers
    hits: Numbers
    lanes: Codes

    def hits_of(self, t: int) -> int:
        """How many hits thread t found."""
        return int(self.ends[t, self.groups[t] - 1]) if self.groups[t] else 0


class Meetings(NamedTuple):
    """Who meets whom. asking: (p,) the points of the groups; asked: (q,) the points of the hits."""

    asking: Numbers
    asked: Numbers
    parts: list[Part]


def meetings_of(level: Level, skin: float, threads: int = 1) -> list[Meetings]:
    """Pairs of a level, and of its points with smaller ones; each once."""
    c, found = level.cells, []
    half = np.array([0, c.row, c.layer - c.row, c.layer, c.layer + c.row])
    found.append(_meetings(level.own, level.own, c, skin, c.fine, half, threads))
    if level.finer:
        ahead = int(np.ceil((level.finer_largest + c.largest + skin) * c.inverse[0]))
        found.append(_meetings(level.finer, level.own, c, skin, ahead, np.concatenate([-half[:0:-1], half]), threads))
    return found


def _meetings(asking: Sorted, asked: Sorted, cells: Cells, skin: float, ahead: int, offsets: Ints, threads: int) -> Meetings:
    """Sweeps over all points, each thread over a run of them, in as many parts as there is room for. ahead: cells along x that reach far enough."""
    parts: list[Part] = []
    points = len(asking.point)
    share = shares(points, threads)
    start, stop = share[:-1].copy(), share[1:]
    front = np.searchsorted(asked.keys[:-1], asking.keys[start][:, None] - ahead + offsets).astype(np.uint64)
    room = 4 * (points // threads) + 64
    while (start < stop).any():
        groups = int((stop - start).max())
        tables = _numbers(threads, groups), _numbers(threads, groups), _numbers(threads, room), np.empty((threads, room), dtype=np.uint8)
        part, before = Part(np.zeros(threads, dtype=np.int64), *tables), start.copy()
        reach = cells.largest, skin, cells.fine, ahead, offsets
        do(_sweep, _sweep_in_threads, shares(threads, threads), asking, asked, asking.radius, asking is asked, *reach, front, start, stop, part)
        parts.append(part)
        if ((start == before) & (start < stop)).any():
            room *= 2
    return Meetings(asking.point, asked.point, parts)


def _numbers(*shape: int) -> Numbers:
    return np.empty(shape, dtype=np.uint32)


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
def _sweep(t, _low, _high, asking, asked, radius, itself, largest, skin, fine, ahead, offsets, fronts, start, stop, part):  # type: ignore[no-untyped-def]
    """Runs of cells round the asking points of thread t, start[t]..stop[t], as many as there is room for: start[t] becomes the point behind them.
    offsets: of the keys of the runs; fronts: (t, r) where they begin. No branch on the answer: it cannot be foretold."""
    front, begin, ends, hits, lanes = fronts[t], part.begin[t], part.ends[t], part.hits[t], part.lanes[t]
    keys, x, y, z = asked.keys, asked.x, asked.y, asked.z
    zero, one = np.uint64(0), np.uint64(1)
    points, room = np.uint64(stop[t]), np.uint64(len(hits))
    i, group, m = np.uint64(start[t]), zero, zero
    rq = largest
    radii = rq, rq, rq, rq
    while i < points:
        n = min(_group(asking.keys, fine, i), points - i)
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
    part.groups[t], start[t] = group, i


@njit(cache=True, error_model="numpy", parallel=True)
def _sweep_in_threads(share, asking, asked, radius, itself, largest, skin, fine, ahead, offsets, fronts, start, stop, part):  # type: ignore[no-untyped-def]
    for t in prange(len(share) - 1):
        _sweep(t, share[t], share[t + 1], asking, asked, radius, itself, largest, skin, fine, ahead, offsets, fronts, start, stop, part)
