"""Volume, centroid and inertia of a clump of spheres that may overlap: of their union, or of the spheres as if they did not.

The union is exact but for rounding. By the divergence theorem a moment of degree d over a body is 1/(d+3) times the integral of the same
monomial times x.n over its surface, which consists of what is left of each sphere when the caps inside other spheres are cut off. On the
unit sphere the surface gradient grad turns these integrals of monomials p of degree l in n into ones over the arcs at the rim,

    integral of (Laplace p - l (l + 1) p) = integral along the rim of nu . grad p,    nu: in the surface, normal to the rim, outward,

and the area (l = 0) into that of (1 - cos theta) dphi about a pole, which has a primitive. Along an arc everything else is a trigonometric
polynomial of degree 3. Where arcs end is found pair by pair, both circles sharing the points where they meet, so that nothing depends on
what meets in one point: touching spheres, centres in a line or plane, circles through one point all work.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Moments = tuple[float, Floats, Floats, Floats]

_TOUCHING = 1e-9  # overlap of two spheres, in units of the smaller radius, that is none: their common volume is some 1e-18 of it
_SAME = 1e-13  # spheres inside each other and circles on top of each other, up to this share of the largest radius, or of the sphere's own
_GAUSS = np.polynomial.legendre.leggauss(24)  # integrates trigonometric polynomials of degree 3 over a full turn to rounding
_TURN = 2.0 * np.pi
_DELTA = np.eye(3)


@dataclass(frozen=True)
class Solid:
    """A homogeneous body. volume. centroid: (3,). inertia: (3, 3) about the centroid, per unit density."""

    volume: float
    centroid: Floats
    inertia: Floats


def union(centre: Floats, radius: Floats) -> Solid:
    """The union of spheres. centre: (k, 3), radius: (k,), any unit of length.

    Relative error below 1e-12 for clumps whose spheres hang together. Raises ValueError for radii that are not positive, for no spheres
    and for numbers that are not finite. Source of the rim integrals: divergence theorem on the sphere; derived here, tested in test_union.py.
    """
    centre, radius = checked(centre, radius)
    unit, origin = radius.max(), centre.mean(axis=0)
    x, r = (centre - origin) / unit, radius / unit
    seen = _not_inside_another(x, r)
    x, r = x[seen], r[seen]
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for i in range(len(r)):
        of_volume, of_first, of_second = _over_patch(x[i], r[i], _patch(*_caps(i, x, r)))
        volume, first, second = volume + of_volume, first + of_first, second + of_second
    middle = first / volume
    return Solid(float(volume * unit**3), origin + unit * middle, _inertia_of(second - volume * np.outer(middle, middle)) * unit**5)


def sum_of_spheres(centre: Floats, radius: Floats) -> Solid:
    """Spheres counted as if they did not overlap, as LAMMPS' fix rigid does. centre: (k, 3), radius: (k,). Source: seed compute-erotate, eq. (5).

    Raises ValueError as `union`.
    """
    centre, radius = checked(centre, radius)
    volume, centroid, inertia = steiner(4.0 / 3.0 * np.pi * radius**3, centre, radius)
    return Solid(float(volume), centroid, inertia)


def steiner(mass: Floats, centre: Floats, radius: Floats) -> tuple[Floats, Floats, Floats]:
    """Mass (...), centre of mass (..., 3) and inertia about it (..., 3, 3) of spheres of mass (..., k), centre (..., k, 3), radius (..., k).

    Sum of 2/5 m R^2 and of Steiner's terms m (r.r - r r^T). Source: seed compute-erotate, eq. (5).
    """
    total = mass.sum(axis=-1)
    middle = np.einsum("...k,...ki->...i", mass, centre) / total[..., None]
    arms = centre - middle[..., None, :]
    spread = np.einsum("...k,...ki,...kj->...ij", mass, arms, arms)
    own = 0.4 * (mass * radius**2).sum(axis=-1)
    return total, middle, _inertia_of(spread) + own[..., None, None] * _DELTA


def checked(centre: Floats, radius: Floats) -> tuple[Floats, Floats]:
    """The spheres as float64 arrays. Raises ValueError where they are none, or not spheres."""
    centre, radius = np.asarray(centre, dtype=np.float64), np.asarray(radius, dtype=np.float64)
    if radius.ndim != 1 or not len(radius) or centre.shape != (len(radius), 3):
        message = f"expected centres (k, 3) and radii (k,) of at least one sphere, got {centre.shape} and {radius.shape}"
        raise ValueError(message)
    good = np.isfinite(centre).all(axis=1) & np.isfinite(radius) & (radius > 0.0)
    if not good.all():
        i = int(np.flatnonzero(~good)[0])
        message = f"expected a finite centre and a radius above zero, got sphere {i + 1}: {' '.join(f'{v:g}' for v in [*centre[i], radius[i]])}"
        raise ValueError(message)
    return centre, radius


def _inertia_of(spread: Floats) -> Floats:
    """tr(S) 1 - S, from the second moments S (..., 3, 3)."""
    return np.asarray(np.trace(spread, axis1=-2, axis2=-1)[..., None, None] * _DELTA - spread)


def _not_inside_another(x: Floats, r: Floats) -> NDArray[np.bool_]:
    """Spheres that are not inside another one; of equal ones the first."""
    apart = np.sqrt(((x[:, None] - x[None]) ** 2).sum(axis=2))
    inside = apart + r[:, None] <= r[None] + _SAME
    earlier = np.arange(len(r))[:, None] > np.arange(len(r))[None]
    return np.asarray(~(inside & (~inside.T | earlier)).any(axis=1))


def _caps(i: int, x: Floats, r: Floats) -> tuple[Floats, Floats]:
    """What other spheres cut off sphere i: caps n.a > h, axes a (m, 3) and heights h (m,)."""
    arms = x - x[i]
    apart = np.sqrt((arms**2).sum(axis=1))
    near = (r[i] + r - apart > _TOUCHING * np.minimum(r[i], r)) & (apart > 0.0)  # bit by bit the same for both spheres
    apart, arms, others = apart[near], arms[near], r[near]
    return arms / apart[:, None], (apart**2 + (r[i] - others) * (r[i] + others)) / (2.0 * apart * r[i])


def _patch(axis: Floats, height: Floats) -> Moments:
    """Integrals of 1, n, n n, n n n over the unit sphere without the caps n.axis > height."""
    alike = np.abs(axis[:, None] - axis[None]).max(axis=2) + np.abs(height[:, None] - height[None]) < _SAME
    facing = np.abs(axis[:, None] + axis[None]).max(axis=2) + np.abs(height[:, None] + height[None]) < _SAME
    if facing.any() or (height <= -1.0).any():  # two caps that cover everything
        return 0.0, np.zeros(3), np.zeros((3, 3)), np.zeros((3, 3, 3))
    first = np.argmax(alike, axis=1) == np.arange(len(height)) if len(height) else np.zeros(0, dtype=bool)
    axis, height = axis[first], height[first]
    frame = _frames(axis)
    which, start, end = _rim(axis, height, frame)
    along = _along(which, start, end, height, frame)
    return _from_rim(_area(axis, height, frame, which, start, end), *along)


def _frames(axis: Floats) -> Floats:
    """Right-handed triads a u w, (m, 3, 3), rows."""
    least = np.zeros_like(axis)
    least[np.arange(len(axis)), np.argmin(np.abs(axis), axis=1)] = 1.0
    u = np.cross(axis, least)
    u /= np.sqrt((u**2).sum(axis=1))[:, None]
    return np.stack([axis, u, np.cross(axis, u)], axis=1)


def _rim(axis: Floats, height: Floats, frame: Floats) -> tuple[NDArray[np.int64], Floats, Floats]:
    """The arcs at the rim of the patch: number of the circle, first and last angle; counted from u to w about the circle's axis."""
    start, length = _hidden(axis, height, frame)
    start, length = np.hstack([start, start - _TURN]), np.hstack([length, length])
    order = np.argsort(start, axis=1)
    start, end = np.take_along_axis(start, order, axis=1), np.take_along_axis(start + length, order, axis=1)
    column = np.ones((len(height), 1))
    reached = np.maximum.accumulate(np.hstack([0.0 * column, end]), axis=1)
    until = np.minimum(np.hstack([start, _TURN * column]), _TURN)
    which, gap = np.nonzero(until > reached)
    return which, reached[which, gap], until[which, gap]


def _hidden(axis: Floats, height: Floats, frame: Floats) -> tuple[Floats, Floats]:
    """The arc of circle j inside cap k: where it starts, in [0, 2 pi], and how long it is, (m, m) each.

    Circles meet at (c × z ± sqrt(c.c - z.z) c) / c.c with c = a_j × a_k, z = h_k a_j - h_j a_k. Exchanging j and k gives the same two
    points bit by bit, and the same answer to whether they meet at all.
    """
    c = np.cross(axis[:, None], axis[None])
    z = height[None, :, None] * axis[:, None] - height[:, None, None] * axis[None]
    cc = _dot(c, c)
    below = _dot(axis[:, None], z)  # h_k - (a_j.a_k) h_j: negative, and circle j is inside cap k for the greater part
    square = cc - _dot(z, z)
    meet = square > 0.0
    root = np.sqrt(np.where(meet, square, 0.0))
    foot, across = np.cross(c, z), root[..., None] * c
    leaves, enters = _angle(foot + across, frame), _angle(foot - across, frame)
    length = leaves - enters
    length += _TURN * np.round((2.0 * np.arctan2(root, below) - length) / _TURN)
    whole = ~meet & (below < 0.0) & ~np.eye(len(height), dtype=bool)
    return np.where(meet, enters % _TURN, np.where(whole, 0.0, _TURN)), np.where(meet, length, np.where(whole, _TURN, 0.0))


def _angle(points: Floats, frame: Floats) -> Floats:
    """Angle of points[j, k] about the axis of circle j."""
    return np.arctan2(_dot(points, frame[:, None, 2]), _dot(points, frame[:, None, 1]))


def _dot(a: Floats, b: Floats) -> Floats:
    """Scalar products along the last axis, always summed in one order."""
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2])


def _along(which: NDArray[np.int64], start: Floats, end: Floats, height: Floats, frame: Floats) -> tuple[Floats, Floats, Floats]:
    """Integrals along the rim of nu, nu n, nu n n: (3,), (3, 3), (3, 3, 3)."""
    node, weight = _GAUSS
    half = 0.5 * (end - start)
    t = (0.5 * (start + end))[:, None] + half[:, None] * node
    a, u, w = np.moveaxis(frame[which], 1, 0)
    h = height[which]
    s = np.sqrt((1.0 - h) * (1.0 + h))
    e = np.cos(t)[..., None] * u[:, None] + np.sin(t)[..., None] * w[:, None]
    n = ((h[:, None] * a)[:, None] + s[:, None, None] * e).reshape(-1, 3)
    nu = ((s[:, None] * a)[:, None] - h[:, None, None] * e).reshape(-1, 3)
    nu *= ((s * half)[:, None] * weight).reshape(-1, 1)
    nn = n[:, :, None] * n[:, None]
    return nu.sum(axis=0), nu.T @ n, (nu.T @ nn.reshape(-1, 9)).reshape(3, 3, 3)


def _area(axis: Floats, height: Floats, frame: Floats, which: NDArray[np.int64], start: Floats, end: Floats) -> float:
    """Area of the patch: 4 pi if the point -pole is in it, and the integral of e.(n × dn)/(1 + e.n), e = pole, along the rim.

    On a circle that is (A + h)/(1 + h A + s B cos tau) - h, with A and B the parts of the pole along and across the circle's axis, and tau
    counted from B; its primitive is 2 atan(g tan(tau/2)) - h tau, g = cos((alpha + beta)/2)/cos((alpha - beta)/2), cos alpha = h, cos beta = A.
    """
    pole = _pole(axis, height)
    whole = 2.0 * _TURN if bool((axis @ -pole < height).all()) else 0.0
    along, u, w = np.moveaxis(frame @ pole, 1, 0)[:, which]
    h = height[which]
    alpha, beta = np.arctan2(np.sqrt((1.0 - h) * (1.0 + h)), h), np.arctan2(np.hypot(u, w), along)
    g = np.cos(0.5 * (alpha + beta)) / np.cos(0.5 * (alpha - beta))
    zero = np.arctan2(w, u)
    turned = np.sign(g) * (_stretched(np.abs(g), end - zero) - _stretched(np.abs(g), start - zero))
    return float(whole + np.sum(h * (end - start) - turned))


def _stretched(g: Floats, tau: Floats) -> Floats:
    """2 atan(g tan(tau/2)), g > 0, without its jumps."""
    return tau + 2.0 * np.arctan2((g - 1.0) * np.sin(tau), (1.0 + g) + (1.0 - g) * np.cos(tau))


def _pole(axis: Floats, height: Floats) -> Floats:
    """Of the coordinate axes and the axes of the caps the one whose opposite is farthest from every circle."""
    candidates = np.vstack([_DELTA, -_DELTA, axis, -axis])
    gap = np.abs(candidates @ axis.T + height).min(axis=1, initial=1.0)
    return np.asarray(candidates[np.argmax(gap)])


def _from_rim(area: float, b1: Floats, b2: Floats, b3: Floats) -> Moments:
    """Laplace of n, n n, n n n is 0, 2 delta, 2 (delta n + delta n + delta n)."""
    m1 = -0.5 * b1
    m2 = (2.0 * area * _DELTA - b2 - b2.T) / 6.0
    traces = _DELTA[:, :, None] * m1
    m3 = (2.0 * _cycled(traces) - _cycled(b3)) / 12.0
    return area, m1, np.asarray(m2), np.asarray(m3)


def _cycled(tensor: Floats) -> Floats:
    """T_abc + T_bca + T_cab."""
    return tensor + np.moveaxis(tensor, 0, 2) + np.moveaxis(tensor, 2, 0)


def _over_patch(c: Floats, r: float, patch: Moments) -> tuple[float, Floats, Floats]:
    """What the patch of the sphere (c, r) adds to the volume and to the first and second moments about the origin."""
    m0, m1, m2, m3 = patch
    f0 = float(r * m0 + c @ m1)  # integrals of x.n, n x.n, n n x.n
    f1 = r * m1 + m2 @ c
    f2 = r * m2 + m3 @ c
    mixed = np.outer(c, f1)
    second = np.outer(c, c) * f0 + r * (mixed + mixed.T) + r * r * f2
    return r * r * f0 / 3.0, r * r * (c * f0 + r * f1) / 4.0, r * r * second / 5.0
