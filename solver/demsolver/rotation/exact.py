"""The free top exactly, by Jacobi's elliptic functions, between two kicks of the torque: a splitting of order 2, whose only error is the torque's.

Without a torque energy and angular momentum stay to rounding at any step, and the orientation is that of the closed form. Along the body axes, in the
order in which the third is the one that the angular momentum m circles about,

    m1 = a cn(u), m2 = b sn(u), m3 = c dn(u),   u' = n            Landau & Lifshitz, Mechanics, section 37

and the body turns about the direction of the angular momentum by the angle psi besides the smallest rotation that takes m to the third axis:

    psi' = (2 E + M m3/I3)/(M + m3)                               Celledoni et al. 2008, doi:10.1137/070704393, in other words

of which the integral over a step is done by Gauss' rule with an error below rounding; longer steps in parts.
"""

from __future__ import annotations

from math import cos, sin, sqrt
from typing import cast

import numpy as np
from numba import njit

from demsolver.algebra import Function, Quat, Vector, compiled, product, pushed, spin_of, to_body

PART, SHORT, SHORTER = 0.25, 0.03, 3e-4
"""Longest part of a step, in u, for seven, four and two points: the nearest pole of dn is K(k') >= pi/2 off, so that n points leave an error of about
(part/(2 pi))^(2 n), some 1e-17."""
RULES = [np.polynomial.legendre.leggauss(n) for n in (7, 4, 2)]
NODES = tuple(float(0.5 * (1.0 + node)) for nodes, _ in RULES for node in nodes)
WEIGHTS = tuple(float(0.5 * weight) for _, weights in RULES for weight in weights)
TINY = 1e-150


def with_arrays(function: Function) -> Function:
    """`compiled` for what makes arrays: the loops that call it make none, and would hand that down."""
    return cast(Function, njit(error_model="numpy", nogil=True, _nrt=True)(function))  # type: ignore[call-overload]


@with_arrays
def jacobi(u: float, complement: float) -> Vector:
    """sn, cn and dn of u by the arithmetic-geometric mean, Abramowitz & Stegun 16.4 in Bulirsch's form. complement: k'^2 = 1 - k^2, from 0 to 1."""
    if complement < TINY:
        grown = np.exp(u)
        sech = 2.0 / (grown + 1.0 / grown)
        return np.tanh(u), sech, sech
    means, roots = np.empty(16), np.empty(16)
    a, b, count = 1.0, complement, 0
    for k in range(16):
        count = k
        means[k] = a
        b = sqrt(b)
        roots[k] = b
        c = 0.5 * (a + b)
        if abs(a - b) <= 1e-9 * a:
            break
        b *= a
        a = c
    u *= c
    sn, cn, dn = sin(u), cos(u), 1.0
    if sn != 0.0:
        a = cn / sn
        c *= a
        for k in range(count, -1, -1):
            b = means[k]
            a *= c
            c *= dn
            dn = (roots[k] + a) / (b + a)
            a = c / b
        a = 1.0 / sqrt(c * c + 1.0)
        sn = a if sn >= 0.0 else -a
        cn = c * sn
    return sn, cn, dn


@compiled
def turned(q: Quat, angmom: Vector, inertia: Vector, h: float) -> Quat:
    """Orientation after a time h without a torque. angmom: in space."""
    m = to_body(q, angmom)
    size = sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2])
    if size < TINY:
        return q
    return _onward(q, _rotation(m, size, inertia, h))


@compiled
def _onward(q: Quat, d: Quat) -> Quat:
    """q o d/|d| of length 1, as a sum of q and what it gains: one rounding, that of the result, where a product has several. d may be of any length;
    of the two with this rotation it takes the one that is nearer to q."""
    length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[3] * d[3])
    part = 1.0 / length if d[0] >= 0.0 else -1.0 / length
    x, y, z = part * d[1], part * d[2], part * d[3]
    too_long = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0
    gained = product(q, (-(x * x + y * y + z * z) / (1.0 + part * d[0]) - 0.5 * too_long, x, y, z))
    return q[0] + gained[0], q[1] + gained[1], q[2] + gained[2], q[3] + gained[3]


@compiled
def _rotation(m: Vector, size: float, inertia: Vector, h: float) -> Quat:
    """By which the body turns, along its own axes."""
    # axes by their moments; an odd order is made right-handed again by turning the last axis round
    i, j, k = 0, 1, 2
    odd = 1.0
    if inertia[i] > inertia[j]:
        i, j, odd = j, i, -odd
    if inertia[j] > inertia[k]:
        j, k, odd = k, j, -odd
    if inertia[i] > inertia[j]:
        i, j, odd = j, i, -odd
    one, two, three = inertia[i], inertia[j], inertia[k]
    # M^2 - 2 E I2: above 0 m circles about the axis of the largest moment, else about that of the smallest
    if not m[k] * m[k] * (three - two) / three > m[i] * m[i] * (two - one) / one:
        i, k, odd, one, three = k, i, -odd, three, one
    x, y, z = m[i], m[j], odd * m[k]
    w, p, s, t = _ordered(x, y, z, size, one, two, three, h)
    vector = (p, s, odd * t)
    first = vector[0] if i == 0 else (vector[1] if j == 0 else vector[2])
    middle = vector[0] if i == 1 else (vector[1] if j == 1 else vector[2])
    last = vector[0] if i == 2 else (vector[1] if j == 2 else vector[2])
    return w, first, middle, last


@compiled
def _ordered(x: float, y: float, z: float, size: float, one: float, two: float, three: float, h: float) -> Quat:
    """The same where two is the middle moment and m circles about the third axis."""
    c_square = z * z + (y * y * three * (two - one) / (two * (three - one)) if three != one else 0.0)
    if three == two or c_square < (TINY * size) ** 2 or c_square == 0.0:
        angle = 0.5 * h * sqrt((x / one) ** 2 + (y / two) ** 2 + (z / three) ** 2)
        part = sin(angle) / size
        return cos(angle), part * x, part * y, part * z
    a_square = x * x + y * y * one * (three - two) / (two * (three - one))
    b_square = y * y + x * x * two * (three - one) / (one * (three - two))
    sign = 1.0 if z >= 0.0 else -1.0
    a, b, c = sqrt(a_square), sign * sqrt(b_square), sign * sqrt(c_square)
    rate = sqrt((three - two) * (three - one) / (one * two)) * abs(c) / three
    rate = rate if three > two else -rate
    complement = (three - one) * (z * z * (three - two) / three - x * x * (two - one) / one) / ((three - two) * c_square * (three - one) / three)
    complement = min(max(complement, 0.0), 1.0)
    twice_energy = x * x / one + y * y / two + z * z / three
    sn, cn, dn = (y / b, x / a, z / c) if a > 0.0 else (0.0, 1.0, 1.0)
    parts = int(abs(rate * h) / PART) + 1
    way = rate * h / parts
    begin, end = (0, 7) if abs(way) > SHORT else ((7, 11) if abs(way) > SHORTER else (11, 13))
    angle = sn_more = cn_more = dn_more = 0.0
    for _ in range(parts):
        reached = sn + sn_more, cn + cn_more, dn + dn_more
        for k in range(begin, end):
            height = abs(c) * (reached[2] + _further(reached, jacobi(way * NODES[k], complement), complement)[2])
            angle += WEIGHTS[k] * (twice_energy + size * height / three) / (size + height)
        more = _further(reached, jacobi(way, complement), complement)
        sn_more, cn_more, dn_more = sn_more + more[0], cn_more + more[1], dn_more + more[2]
    return _between((x, y, z), (a * cn_more, b * sn_more, c * dn_more), size, sign, 0.5 * h / parts * angle)


@compiled
def _further(here: Vector, other: Vector, complement: float) -> Vector:
    """What sn, cn and dn gain where another argument is added to theirs, from the addition theorem (Abramowitz & Stegun 16.17)."""
    sn, cn, dn = here
    s, c, d = other
    square = 1.0 - complement
    crossed = square * sn * sn * s * s
    c_lost, d_lost = s * s / (1.0 + c), square * s * s / (1.0 + d)
    below = 1.0 / (1.0 - crossed)
    return (
        (s * cn * dn + sn * (crossed - c_lost * d - d_lost)) * below,
        (cn * (crossed - c_lost) - sn * dn * s * d) * below,
        (dn * (crossed - d_lost) - square * sn * cn * s * c) * below,
    )


@compiled
def _between(m: Vector, more: Vector, size: float, sign: float, angle: float) -> Quat:
    """Upright by the smallest rotation from m to the third axis (its other end if sign is -1), down to m + more, and about that by twice the angle.
    Of any length.

    The vector part is as small as the step, and so is its rounding. As a product of rotations it would be rounded as they are, in a slow motion
    always the same way: a drift of the energy. So would be the rounding of `size` were it to turn about the third axis."""
    x, y, z = m
    later = x + more[0], y + more[1], z + more[2]
    before, after = size + sign * z, size + sign * later[2]
    part = 1.0 / (before * after)
    tilt = (
        1.0 + part * (x * later[0] + y * later[1]),
        part * (sign * before * more[1] - y * more[2]), part * (x * more[2] - sign * before * more[0]), part * (y * more[0] - x * more[1]),
    )  # fmt: skip
    sine = sin(angle) / size
    return product(tilt, (cos(angle), sine * later[0], sine * later[1], sine * later[2]))


@compiled
def first(q: Quat, angmom: Vector, omega: Vector, torque: Vector, inertia: Vector, h: float) -> tuple[Quat, Vector, Vector]:
    """Orientation of the next step, and angular momentum and spin of half a step before it, which forces see."""
    angmom = pushed(angmom, torque, 0.5 * h)
    q = turned(q, angmom, inertia, h)
    return q, angmom, spin_of(q, angmom, inertia)


@compiled
def second(q: Quat, angmom: Vector, omega: Vector, torque: Vector, inertia: Vector, h: float) -> tuple[Vector, Vector]:
    """Angular momentum and spin at the end of the step, with its torque."""
    angmom = pushed(angmom, torque, 0.5 * h)
    return angmom, spin_of(q, angmom, inertia)
