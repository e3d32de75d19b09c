"""The near list: which listed pairs can touch within the next steps. A template like kernel.py,
compiled once for all scenes with the same constants.

In dense flow one listed pair in seven touches. At a renewal every listed pair is looked at: in straight flight at its present velocities the distance of
two centres cannot fall below d + min(0, v.n) t. A particle departs from its straight flight by at most dt times the sum, over the steps, of the sum of
the largest change of a velocity in each step so far; a sweep tells that change. The list is renewed before anyone has departed by more than it allows
for, or when its span of steps is over: a pair that is not in it cannot touch. Pairs that touch, or did at the last step, are always in it, but
for those in which neither moves while something sleeps (SLEEPS).

Step laws move particles by more than their velocities, so there the list is renewed in every step, for that step.
"""

# ruff: noqa: F821
from math import sqrt

import numpy as np
from numba import prange

LEAST, MOST = 1e-5, 3e-2  # of the mean radius: how far a particle may depart from straight flight before the list is renewed
CLOSE = 1.0 + 1e-9  # for rounding
SHORTEST, LONGEST = 2, 40  # steps between renewals
FIRST, END, CROSS_FIRST, CROSS_END, KEPT_FIRST, KEPT_END, APART = range(7)  # columns of near.chunks
START_WATCH = (np.inf, 0.0, 0.0, 0)  # departure so far and allowed, sum of the changes of velocity, steps left


@compiled
def near_chunk(c, x, v, radius, movers, p, near, shifts, equal, span, leeway):
    """Near pairs of the rows of chunk c: those that straight flight for the time `span` brings within `leeway`, and those that touch."""
    stop = min(x.shape[0], (c + 1) * CHUNK)
    begin = np.uint64(p.first[c * CHUNK])  # places are unsigned: of a signed one Numba asks whether it counts from the end
    found, touching = begin, np.uint64(0)
    for k in range(begin, np.uint64(p.first[stop])):
        i, j = np.uint64(p.row[k]), np.uint64(p.partner[k])
        dx, dy, dz = x[i, 0] - x[j, 0], x[i, 1] - x[j, 1], x[i, 2] - x[j, 2]
        if PERIODIC:
            s = np.int64(p.code[k])
            if s != HOME:
                sign = -1.0
                if s >= PARTNER_FEELS:
                    sign, s = 1.0, s - PARTNER_FEELS
                dx, dy, dz = dx + sign * shifts[s, 0], dy + sign * shifts[s, 1], dz + sign * shifts[s, 2]
        one, other = np.float64(np.int64(i) < movers), np.float64(np.int64(j) < movers)
        closing = dx * (other * v[j, 0] - one * v[i, 0]) + dy * (other * v[j, 1] - one * v[i, 1])
        closing += dz * (other * v[j, 2] - one * v[i, 2])
        close = CLOSE * (leeway + (equal[0] + equal[0] if UNIFORM else radius[i] + radius[j]))
        square = dx * dx + dy * dy + dz * dz
        # without a square root: distance - closing speed * span < close, times the distance
        ahead = square - max(closing, 0.0) * span
        near.listing[found] = k
        touches = p.touching[k] & np.uint64(1)
        can_touch = (ahead <= 0.0) | (ahead * ahead < close * close * square) | (touches != 0)
        if SLEEPS:
            can_touch &= one + other > 0.0
        found += np.uint64(can_touch)
        touching += touches
    q, u = np.uint64(near.chunks[c, FIRST]), np.uint64(near.chunks[c, CROSS_FIRST])
    for h in range(begin, found):
        k = np.uint64(near.listing[h])
        if p.partner[k] < stop:
            take(q, k, p, near)
            q += np.uint64(1)
        else:
            take(u, k, p, near)
            u += np.uint64(1)
    near.chunks[c, END], near.chunks[c, CROSS_END], near.chunks[c, KEPT_END] = q, u, near.chunks[c, KEPT_FIRST]
    near.chunks[c, APART] = max(0, np.int64(found - begin) - np.int64(touching))


@inlined
def take(q, k, p, near):
    """Listed pair k becomes near entry q."""
    near.row[q], near.partner[q], near.entry[q] = p.row[k], p.partner[k], k
    if PERIODIC:
        near.code[q] = p.code[k]


@shared_threaded
def near_shares(x, v, radius, movers, p, near, shifts, equal, span, leeway):
    """The near pairs of all rows, by all threads: Numba hands them no tuple within a tuple, as the bodies are."""
    for t in prange(near.share.shape[0] - 1):
        for c in range(near.share[t], near.share[t + 1]):
            near_chunk(c, x, v, radius, movers, p, near, shifts, equal, span, leeway)


@shared
def list_near(b, movers, p, near, shifts, equal, span, leeway):
    """The near pairs of all rows, and which chunks each thread does: about as much work for each."""
    chunks = near.chunks.shape[0]
    if THREADED:
        near_shares(b.x, b.v, b.radius, movers, p, near, shifts, equal, span, leeway)
        share_out(near, b.x.shape[0])
    else:
        for c in range(chunks):
            near_chunk(c, b.x, b.v, b.radius, movers, p, near, shifts, equal, span, leeway)


@compiled
def share_out(near, n):
    """Cuts the chunks into runs of about the same work: between chunks, and the rest."""
    cut(near.cross_share, CROSS_FIRST, CROSS_END, 0, near, n)
    cut(near.share, FIRST, END, 1, near, n)


@compiled
def cut(share, first, end, rows, near, n):
    """Cuts the chunks by their entries and, with rows = 1, by their rows: an entry takes about as long as five rows."""
    chunks, threads = near.chunks.shape[0], share.shape[0] - 1
    work = np.int64(0)
    for c in range(chunks):
        work += 5 * (near.chunks[c, end] - near.chunks[c, first]) + rows * (min(n, (c + 1) * CHUNK) - c * CHUNK)
    t = 1
    done = np.int64(0)
    for c in range(chunks):
        part = 5 * (near.chunks[c, end] - near.chunks[c, first]) + rows * (min(n, (c + 1) * CHUNK) - c * CHUNK)
        while t < threads and (done + part // 2) * threads >= t * work:
            share[t] = c
            t += 1
        done += part
    while t < threads:
        share[t] = chunks
        t += 1


@shared
def renew_near(watch, b, movers, p, near, shifts, equal, dt, jump):
    """Keeps the near list true at the present positions. jump: largest change of a velocity in the last sweep."""
    departure, allowed, gained, left = watch
    if SHIFTING:
        list_near(b, movers, p, near, shifts, equal, 0.0, 0.0)
        return watch
    gained += jump
    departure += dt * gained
    left -= 1
    if departure <= allowed and left >= 0:
        return departure, allowed, gained, left
    pull = 0.75 * dt * jump
    steps = LONGEST
    if pull * LONGEST * (LONGEST + 1) > near.scale[2] * near.scale[0]:
        steps = max(SHORTEST, int(sqrt(near.scale[2] * near.scale[0] / pull)))
    allowed = pull * steps * (steps + 1)
    list_near(b, movers, p, near, shifts, equal, steps * dt, 2.0 * allowed)
    # the pairs that do not touch are looked at in every step, all that are listed once: as much for the one as for the other costs least
    looks = 2.0 * steps * near.chunks[:, APART].sum()
    near.scale[2] = min(MOST, max(LEAST, near.scale[2] * min(2.0, max(0.5, p.partner.shape[0] / max(1.0, looks)))))
    return 0.0, allowed, 0.0, steps
