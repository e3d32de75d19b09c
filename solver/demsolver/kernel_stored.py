"""The energy in all contacts: a template like kernel.py, behind it."""

# ruff: noqa: F821
from math import sqrt

import numpy as np


@entry
def stored(b, p, shifts, coefficients, ntypes, walls, dt):
    """Elastic energy in all contacts: (normal, tangential, rolling), at the current positions and histories."""
    normal = tangential = rolling = 0.0
    if PAIRS:
        for i in range(b.x.shape[0]):
            for k in range(p.first[i], p.first[i + 1]):
                a, o, s = i, np.int64(p.partner[k]), HOME
                if PERIODIC:
                    s = np.int64(p.code[k])
                    if s >= PARTNER_FEELS:
                        a, o, s = o, a, s - PARTNER_FEELS
                square = vn = 0.0
                for c in range(3):
                    d = b.x[a, c] - b.x[o, c]
                    if PERIODIC:
                        d -= shifts[s, c]
                    square += d * d
                    vn += d * (b.v[a, c] - b.v[o, c])
                reach = b.radius[a] + b.radius[o]
                if square < reach * reach or (BEYOND and p.touching[k] & 1):
                    distance = sqrt(square)
                    ma, mo = heft(b, a), heft(b, o)
                    meff = ma * mo / (ma + mo)
                    if FROZEN:
                        if b.frozen[a]:
                            meff = mo
                        elif b.frozen[o]:
                            meff = ma
                    row = 0 if ONE_LAW else b.kind[a] * ntypes + b.kind[o]
                    ra, ro = rough_size(b, a), rough_size(b, o)
                    overlap, reff = reach - distance, ra * ro / (ra + ro)
                    if SHAPES and (b.axes[a, 0] > 0.0 or b.axes[o, 0] > 0.0):
                        dx, dy, dz = between(a, o, s, b.x, shifts)
                        state, overlap, _, _, _, reff = meet(k, a, o, dx, dy, dz, b, p.memory, GEOMETRY, SHAPE_CONTACT, p.touching[k] & 1 != 0, 0.0, False)
                        if state != TOUCHES:
                            continue
                    en, et, er = pair_stored(p.memory, k, overlap, ra, 1.0 / ro, reff, meff, vn / distance, dt, coefficients, row)
                    part = 0.5 if s != HOME else 1.0
                    normal += part * en
                    tangential += part * et
                    rolling += part * er
    for i in range(b.x.shape[0]):
        en, et, er = wall_stored(i, b, walls, dt)
        normal += en
        tangential += et
        rolling += er
    return normal, tangential, rolling
