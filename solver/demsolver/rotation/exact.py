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

from demsolver.algebra import Function, Quat, Vector, compiled, normalised, product, pushed, spin_of, to_body

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
    d = _rotation(m, size, inertia, h)
    return normalised(product(q, d))


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
    sn0, cn0, dn0 = (y / b, x / a, z / c) if a > 0.0 else (0.0, 1.0, 1.0)
    parts = int(abs(rate * h) / PART) + 1
    way = rate * h / parts
    begin, end = (0, 7) if abs(way) > SHORT else ((7, 11) if abs(way) > SHORTER else (11, 13))
    angle = 0.0
    sn1, cn1, dn1 = sn0, cn0, dn0
    for _ in range(parts):
        for k in range(begin, end):
            height = sign * c * _summed(sn1, cn1, dn1, jacobi(way * NODES[k], complement), complement)[2]
            angle += WEIGHTS[k] * (twice_energy + size * height / three) / (size + height)
        sn1, cn1, dn1 = _summed(sn1, cn1, dn1, jacobi(way, complement), complement)
    part = 1.0 / sqrt(sn1 * sn1 + cn1 * cn1)
    sn1, cn1 = part * sn1, part * cn1
    dn1 = sqrt(cn1 * cn1 + complement * sn1 * sn1)
    angle *= 0.5 * h / parts
    before, after = _upright(x, y, z, size, sign), _upright(a * cn1, b * sn1, c * dn1, size, sign)
    return product((before[0], -before[1], -before[2], -before[3]), product((cos(angle), 0.0, 0.0, sign * sin(angle)), after))


@compiled
def _summed(sn: float, cn: float, dn: float, other: Vector, complement: float) -> Vector:
    """The addition theorem (Abramowitz & Stegun 16.17)."""
    s, c, d = other
    square = 1.0 - complement
    below = 1.0 / (1.0 - square * sn * sn * s * s)
    return (sn * c * d + s * cn * dn) * below, (cn * c - sn * dn * s * d) * below, (dn * d - square * sn * cn * s * c) * below


@compiled
def _upright(x: float, y: float, z: float, size: float, sign: float) -> Quat:
    """The smallest rotation that takes m to the third axis, or to its other end if sign is -1."""
    return normalised((size + sign * z, sign * y, -sign * x, 0.0))


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
