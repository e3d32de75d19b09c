"""Contact of two bodies as LIGGGHTS defines it: at the point p where both potentials are equal and their gradients opposite,

    grad fi + mu grad fj = 0,  fi = fj;   contact where fi < 0;   n = (grad fj - grad fi)/|...|, from j to i;   overlap: the chord through p along n

Here p is converged to rounding, where LIGGGHTS ends at an angle of 1e-5. p is where max(fi, fj) is least, and both are convex: there is one.
Newton from a guess, damped where it does not descend; from the bodies' spheres, whose exponents then grow, where there is none.
"""

from __future__ import annotations

from math import sqrt

from demsolver.rotation._algebra import Vector, compiled, to_space
from demsolver.superquadric import Body
from demsolver.superquadric.surface import Symmetric, curve, in_space, leaves, seen, slope

CLOSE = 1e-14
"""Of the sum of the squares of what is not yet 0: angle of the gradients, and mismatch of the potentials as a length over the body's size."""
MOST = 60
SMALLEST_DAMPING = 1e-12


@compiled
def _both(p: Vector, i: Body, j: Body) -> tuple[float, float, Vector, Vector]:
    """Potentials, and gradients in space."""
    fi, gi = slope(seen(p, i), i)
    fj, gj = slope(seen(p, j), j)
    return fi, fj, to_space(i.q, gi), to_space(j.q, gj)


@compiled
def _size(v: Vector) -> float:
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


@compiled
def _off(fi: float, fj: float, gi: Vector, gj: Vector, scale: float) -> float:
    """What is not yet 0, squared: gi/|gi| + gj/|gj|, and (fi - fj)/(|gi| + |gj|) over a length."""
    a, b = _size(gi), _size(gj)
    if not (a > 0.0 and b > 0.0):
        return 1e300
    x, y, z = gi[0] / a + gj[0] / b, gi[1] / a + gj[1] / b, gi[2] / a + gj[2] / b
    f = (fi - fj) / ((a + b) * scale)
    return x * x + y * y + z * z + f * f


@compiled
def _solved(h: Symmetric, damping: float, r: Vector) -> Vector:
    """(H + damping 1)^-1 r."""
    xx, yy, zz, xy, xz, yz = h[0] + damping, h[1] + damping, h[2] + damping, h[3], h[4], h[5]
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    det = xx * a + xy * b + xz * c
    d, e, f = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    return (
        (a * r[0] + b * r[1] + c * r[2]) / det,
        (b * r[0] + d * r[1] + e * r[2]) / det,
        (c * r[0] + e * r[1] + f * r[2]) / det,
    )


@compiled
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def newton(p: Vector, i: Body, j: Body) -> tuple[Vector, bool, int]:
    """The point of equal potentials from a guess; whether it was found, and steps taken."""
    scale = min(i.axes[0], i.axes[1], i.axes[2], j.axes[0], j.axes[1], j.axes[2])
    fi, fj, gi, gj = _both(p, i, j)
    off, damping, steps = _off(fi, fj, gi, gj, scale), 0.0, 0
    while steps < MOST:
        if off < CLOSE * CLOSE:
            return p, True, steps
        steps += 1
        hi, hj = in_space(curve(seen(p, i), i), i), in_space(curve(seen(p, j), j), j)
        mu = _size(gi) / max(_size(gj), 1e-300)
        h = (
            hi[0] + mu * hj[0], hi[1] + mu * hj[1], hi[2] + mu * hj[2], hi[3] + mu * hj[3], hi[4] + mu * hj[4], hi[5] + mu * hj[5],
        )  # fmt: skip
        stiff = (h[0] + h[1] + h[2]) / 3.0
        wrong = gi[0] + mu * gj[0], gi[1] + mu * gj[1], gi[2] + mu * gj[2]
        apart = gi[0] - gj[0], gi[1] - gj[1], gi[2] - gj[2]
        better = False
        for _ in range(40):
            s = _solved(h, damping * stiff, wrong)
            w = _solved(h, damping * stiff, gj)
            share = (fi - fj - _dot(apart, s)) / _dot(apart, w)
            move = s[0] + share * w[0], s[1] + share * w[1], s[2] + share * w[2]
            part = 1.0
            way = _size(move)
            if not way < 1e300:
                damping = max(4.0 * damping, 1e-6)
                continue
            if way > scale:
                part = scale / way
            for _ in range(4):
                q = p[0] - part * move[0], p[1] - part * move[1], p[2] - part * move[2]
                new_fi, new_fj, new_gi, new_gj = _both(q, i, j)
                new = _off(new_fi, new_fj, new_gi, new_gj, scale)
                if new < off:
                    better = True
                    break
                part *= 0.5
            if better:
                break
            if way < 1e-15 * scale:
                return p, off < 1e4 * CLOSE * CLOSE, steps
            damping = max(8.0 * damping, 1e-6)
        if not better:
            return p, off < 1e4 * CLOSE * CLOSE, steps
        damping = 0.25 * damping if damping > SMALLEST_DAMPING else 0.0
        p, fi, fj, gi, gj, off = q, new_fi, new_fj, new_gi, new_gj, new
    return p, off < 1e4 * CLOSE * CLOSE, steps


@compiled
def _grown(body: Body, radius: float, part: float) -> Body:
    """Between a sphere of that radius and the body."""
    axes = radius + part * (body.axes[0] - radius), radius + part * (body.axes[1] - radius), radius + part * (body.axes[2] - radius)
    n1, n2 = 2.0 + part * (body.n1 - 2.0), 2.0 + part * (body.n2 - 2.0)
    return Body(body.x, body.q, axes, n1, n2, 2.0 ** (2.0 - max(n1, n2)))


@compiled
def afresh(i: Body, j: Body) -> tuple[Vector, bool, int]:
    """The point of equal potentials without a guess: from two spheres, which become the bodies step by step."""
    ri, rj = (i.axes[0] * i.axes[1] * i.axes[2]) ** (1.0 / 3.0), (j.axes[0] * j.axes[1] * j.axes[2]) ** (1.0 / 3.0)
    part = ri / (ri + rj)
    p = (
        part * j.x[0] + (1.0 - part) * i.x[0], part * j.x[1] + (1.0 - part) * i.x[1], part * j.x[2] + (1.0 - part) * i.x[2],
    )  # fmt: skip
    count = max(8, int(max(i.n1, i.n2, j.n1, j.n2)))
    found, steps = True, 0
    for k in range(1, count + 1):
        p, found, more = newton(p, _grown(i, ri, k / count), _grown(j, rj, k / count))
        steps += more
    return p, found, steps


@compiled
def touch(p: Vector, i: Body, j: Body) -> tuple[float, Vector]:
    """Overlap at the point of equal potentials p, 0 where they do not touch, and unit normal from j to i."""
    fi, fj, gi, gj = _both(p, i, j)
    n = gj[0] - gi[0], gj[1] - gi[1], gj[2] - gi[2]
    size = _size(n)
    n = n[0] / size, n[1] / size, n[2] / size
    if max(fi, fj) >= 0.0:
        return 0.0, n
    return leaves(p, (-n[0], -n[1], -n[2]), i) + leaves(p, n, j), n
