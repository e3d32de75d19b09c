"""Contact of two bodies, at the point p where two convex functions are equal and their gradients opposite: where the larger of them is least.

    grad i + mu grad j = 0,  i = j

POTENTIAL: of LIGGGHTS' functions f. Contact where they are below 0; normal along grad j - grad i, overlap the chord through p along it. LIGGGHTS ends
its iteration at an angle of 1e-5, here p is converged to rounding. The force along this normal has no energy of which it is the gradient.

GAUGE: of the factors G by which each body grows to reach p. Both grown by G = lam at p touch each other there. The overlap is (1 - lam) L with
a length L of the pair, and a force that derives from an energy U(overlap) acts at p along the normal, with

    -dU/dx_i = U' L lam/(h_i + h_j) n,    h: distances of the tangent planes at p, of the grown bodies, from the centres

(Perram & Wertheim 1985, doi:10.1016/0021-9991(85)90171-8, for ellipsoids). For spheres, with L the sum of the radii, it is their overlap.
It has a solution as long as the centres are apart; POTENTIAL has none where a centre lies too deep in the other body.

Newton from a guess, damped where it does not descend; from spheres, which become the bodies step by step, where there is none.
"""

from __future__ import annotations

from math import sqrt

from demsolver.algebra import Vector, compiled, dot, length, to_space
from demsolver.superquadric import Body
from demsolver.superquadric.surface import Symmetric, curvature, curve, gauge, gauge_curve, in_space, leaves, seen, slope

POTENTIAL, GAUGE = 0, 1
CLOSE = 1e-14
"""Of the sum of the squares of what is not yet 0: angle of the gradients, and mismatch of the potentials as a length over the body's size."""
MOST = 60
SMALLEST_DAMPING = 1e-12


@compiled
def _both(p: Vector, i: Body, j: Body, kind: int) -> tuple[float, float, Vector, Vector]:
    """Both functions, and their gradients in space."""
    if kind == GAUGE:
        fi, gi = gauge(seen(p, i), i)
        fj, gj = gauge(seen(p, j), j)
    else:
        fi, gi = slope(seen(p, i), i)
        fj, gj = slope(seen(p, j), j)
    return fi, fj, to_space(i.q, gi), to_space(j.q, gj)


@compiled
def _bend(p: Vector, body: Body, kind: int) -> Symmetric:
    """Second derivatives in space."""
    u = seen(p, body)
    return in_space(gauge_curve(u, body) if kind == GAUGE else curve(u, body), body)


@compiled
def _off(fi: float, fj: float, gi: Vector, gj: Vector, scale: float) -> float:
    """What is not yet 0, squared: gi/|gi| + gj/|gj|, and (fi - fj)/(|gi| + |gj|) over a length."""
    a, b = length(gi), length(gj)
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
def newton(p: Vector, i: Body, j: Body, kind: int) -> tuple[Vector, bool, int]:
    """The point p from a guess; whether it was found, and steps taken. kind: POTENTIAL or GAUGE."""
    scale = min(i.axes[0], i.axes[1], i.axes[2], j.axes[0], j.axes[1], j.axes[2])
    fi, fj, gi, gj = _both(p, i, j, kind)
    off, damping, steps = _off(fi, fj, gi, gj, scale), 0.0, 0
    while steps < MOST:
        if off < CLOSE * CLOSE:
            return p, True, steps
        steps += 1
        hi, hj = _bend(p, i, kind), _bend(p, j, kind)
        mu = length(gi) / max(length(gj), 1e-300)
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
            share = (fi - fj - dot(apart, s)) / dot(apart, w)
            move = s[0] + share * w[0], s[1] + share * w[1], s[2] + share * w[2]
            part = 1.0
            way = length(move)
            if not way < 1e300:
                damping = max(4.0 * damping, 1e-6)
                continue
            if way > scale:
                part = scale / way
            for _ in range(4):
                q = p[0] - part * move[0], p[1] - part * move[1], p[2] - part * move[2]
                new_fi, new_fj, new_gi, new_gj = _both(q, i, j, kind)
                new = _off(new_fi, new_fj, new_gi, new_gj, scale)
                if new < off:
                    better = True
                    break
                part *= 0.5
            if better:
                break
            if way < 1e-15 * scale:
                break
            damping = max(8.0 * damping, 1e-6)
        if not better:
            break
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
def _from_spheres(i: Body, j: Body, kind: int) -> tuple[Vector, bool, int]:
    """The point p from two spheres, which become the bodies step by step; where that fails, in four times as many steps, and again."""
    ri, rj = (i.axes[0] * i.axes[1] * i.axes[2]) ** (1.0 / 3.0), (j.axes[0] * j.axes[1] * j.axes[2]) ** (1.0 / 3.0)
    part = ri / (ri + rj)
    p = start = (
        part * j.x[0] + (1.0 - part) * i.x[0], part * j.x[1] + (1.0 - part) * i.x[1], part * j.x[2] + (1.0 - part) * i.x[2],
    )  # fmt: skip
    count = max(8, int(max(i.n1, i.n2, j.n1, j.n2)))
    found, steps = False, 0
    for _ in range(3):
        p = start
        for k in range(1, count + 1):
            p, found, more = newton(p, _grown(i, ri, k / count), _grown(j, rj, k / count), kind)
            steps += more
        if found:
            break
        count *= 4
    return p, found, steps


@compiled
def afresh(i: Body, j: Body, kind: int) -> tuple[Vector, bool, int]:
    """The point p without a guess: from spheres, or POTENTIAL from the point of GAUGE, which is found between thin bodies of very different size too.
    kind: POTENTIAL or GAUGE."""
    p, found, steps = _from_spheres(i, j, kind)
    if not found and kind == POTENTIAL:
        p, found, more = _from_spheres(i, j, GAUGE)
        steps += more
        if found:
            p, found, more = newton(p, i, j, POTENTIAL)
            steps += more
    return p, found, steps


@compiled
def chord(p: Vector, i: Body, j: Body) -> tuple[float, Vector]:
    """Overlap at the point of equal potentials p, 0 where they do not touch, and unit normal from j to i."""
    fi, fj, gi, gj = _both(p, i, j, POTENTIAL)
    n = gj[0] - gi[0], gj[1] - gi[1], gj[2] - gi[2]
    size = length(n)
    n = n[0] / size, n[1] / size, n[2] / size
    # the potential of both, whatever of p is lost to rounding: that of a blunt body is smaller than the steeper one's rounding
    if fi * length(gj) + fj * length(gi) >= 0.0:
        return 0.0, n
    return leaves(p, (-n[0], -n[1], -n[2]), i) + leaves(p, n, j), n


@compiled
def chord_curvature(p: Vector, n: Vector, i: Body, j: Body, kind: int) -> float:
    """Sum of the curvatures (surface.curvature) at both ends of the chord through p along n."""
    si, sj = leaves(p, (-n[0], -n[1], -n[2]), i), leaves(p, n, j)
    a = p[0] - si * n[0], p[1] - si * n[1], p[2] - si * n[2]
    b = p[0] + sj * n[0], p[1] + sj * n[1], p[2] + sj * n[2]
    return curvature(seen(a, i), i, kind) + curvature(seen(b, j), j, kind)


@compiled
def grown(p: Vector, i: Body, j: Body) -> tuple[float, float, Vector]:
    """lam, by which both bodies grow to touch each other at p (below 1: they overlap), lam/(h_i + h_j), and unit normal from j to i."""
    fi, fj, gi, gj = _both(p, i, j, GAUGE)
    n = gj[0] - gi[0], gj[1] - gi[1], gj[2] - gi[2]
    size = length(n)
    n = n[0] / size, n[1] / size, n[2] / size
    lam = sqrt(0.5 * (fi + fj) + 1.0)
    # |grad G| = |grad G^2|/(2 G), which is lam/h for a function of first degree
    a, b = length(gi) / (2.0 * lam), length(gj) / (2.0 * lam)
    return lam, a * b / (a + b), n
