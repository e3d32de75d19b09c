"""The function f = k {(|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 - 1} of a superquadric: below 0 inside, convex for n1, n2 >= 2."""

from __future__ import annotations

from demsolver.algebra import Vector, compiled, dot, to_body, to_space
from demsolver.superquadric import Body

MEAN, GAUSSIAN = 1, 2
Symmetric = tuple[float, float, float, float, float, float]
"""xx, yy, zz, xy, xz, yz of a matrix."""


@compiled
def power(u: float, n: float) -> float:
    """u^n for u >= 0; small whole numbers by products."""
    if n == 2.0:
        return u * u
    if n == 1.0:
        return u
    if n == 0.0:
        return 1.0
    if n == 3.0:
        return u * u * u
    if n == 4.0:
        return (u * u) * (u * u)
    if n == 6.0:
        return (u * u) * (u * u) * (u * u)
    return float(u**n)


@compiled
def value(u: Vector, body: Body) -> float:
    """f at u, along the body axes."""
    a, b, c = body.axes
    across = power(abs(u[0]) / a, body.n2) + power(abs(u[1]) / b, body.n2)
    if body.n1 != body.n2:
        across = across ** (body.n1 / body.n2)
    return body.scale * (across + power(abs(u[2]) / c, body.n1) - 1.0)


@compiled
def plain(u: Vector, body: Body) -> tuple[float, Vector]:
    """f/k + 1, which is 0 at the centre and 1 on the surface, and its gradient at u, along the body axes."""
    (a, b, c), n1, n2 = body.axes, body.n1, body.n2
    x, y, z = abs(u[0]) / a, abs(u[1]) / b, abs(u[2]) / c
    px, py, pz = power(x, n2 - 1.0), power(y, n2 - 1.0), power(z, n1 - 1.0)
    across = px * x + py * y
    outer = 1.0
    if n1 != n2:
        outer = across ** (n1 / n2 - 1.0) if across > 0.0 else 0.0
    gx, gy, gz = n1 * outer * px / a, n1 * outer * py / b, n1 * pz / c
    f = outer * across + pz * z
    return f, (gx if u[0] >= 0.0 else -gx, gy if u[1] >= 0.0 else -gy, gz if u[2] >= 0.0 else -gz)


@compiled
def slope(u: Vector, body: Body) -> tuple[float, Vector]:
    """f and its gradient at u, along the body axes."""
    f, g = plain(u, body)
    return body.scale * (f - 1.0), (body.scale * g[0], body.scale * g[1], body.scale * g[2])


@compiled
def curve(u: Vector, body: Body) -> Symmetric:
    """Second derivatives of f at u, along the body axes: xx, yy, zz, xy, xz, yz, of which the last two are 0."""
    (a, b, c), n1, n2 = body.axes, body.n1, body.n2
    x, y, z = abs(u[0]) / a, abs(u[1]) / b, abs(u[2]) / c
    dx, dy = power(x, n2 - 2.0), power(y, n2 - 2.0)
    across = dx * x * x + dy * y * y
    part, outer, inner = body.scale * n1, 1.0, 0.0
    if n1 != n2 and across > 0.0:
        outer = across ** (n1 / n2 - 1.0)
        inner = (n1 - n2) * outer / across
    elif n1 != n2:
        outer = 0.0
    xx = part * (outer * (n2 - 1.0) * dx + inner * dx * dx * x * x) / (a * a)
    yy = part * (outer * (n2 - 1.0) * dy + inner * dy * dy * y * y) / (b * b)
    xy = part * inner * dx * x * dy * y / (a * b)
    zz = part * (n1 - 1.0) * power(z, n1 - 2.0) / (c * c)
    return xx, yy, zz, xy if (u[0] >= 0.0) == (u[1] >= 0.0) else -xy, 0.0, 0.0


@compiled
def gauge(u: Vector, body: Body) -> tuple[float, Vector]:
    """G^2 - 1 and its gradient, where G is the factor by which the body grows to reach u: (f/k + 1)^(2/n1) - 1. Convex, of second degree in u."""
    f, g = plain(u, body)
    if not f > 0.0:
        return -1.0, (0.0, 0.0, 0.0)
    square = f ** (2.0 / body.n1)
    part = 2.0 / body.n1 * square / f
    return square - 1.0, (part * g[0], part * g[1], part * g[2])


@compiled
def gauge_curve(u: Vector, body: Body) -> Symmetric:
    """Second derivatives of G^2, along the body axes."""
    f, g = plain(u, body)
    h = curve(u, body)
    f = max(f, 1e-300)
    part = 2.0 / body.n1 * f ** (2.0 / body.n1 - 1.0)
    more = part * (2.0 / body.n1 - 1.0) / f
    part /= body.scale
    return (
        part * h[0] + more * g[0] * g[0], part * h[1] + more * g[1] * g[1], part * h[2] + more * g[2] * g[2],
        part * h[3] + more * g[0] * g[1], more * g[0] * g[2], more * g[1] * g[2],
    )  # fmt: skip


@compiled
def curvature(u: Vector, body: Body, kind: int) -> float:
    """Of the surface where the line from the centre to u goes through it, u along the body axes. kind: MEAN |n.H n - tr H|/(2|g|), or GAUSSIAN, the
    root of its size, sqrt |det [H g; g 0]|/|g|^2, with the gradient g, n = g/|g|, and second derivatives H."""
    f, _ = plain(u, body)
    part = f ** (-1.0 / body.n1)
    at = part * u[0], part * u[1], part * u[2]
    _, g = slope(at, body)
    xx, yy, zz, xy, xz, yz = curve(at, body)
    square = dot(g, g)
    if kind == MEAN:
        along = xx * g[0] * g[0] + yy * g[1] * g[1] + zz * g[2] * g[2] + 2.0 * (xy * g[0] * g[1] + xz * g[0] * g[2] + yz * g[1] * g[2])
        return float(abs(along / square - xx - yy - zz) / (2.0 * square**0.5))
    # g . adj(H) g
    a, b, c = yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy
    d, e, h = xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - xx * yz
    det = a * g[0] * g[0] + b * g[1] * g[1] + c * g[2] * g[2] + 2.0 * (d * g[0] * g[1] + e * g[0] * g[2] + h * g[1] * g[2])
    return float(abs(det) ** 0.5 / square)


@compiled
def in_space(h: Symmetric, body: Body) -> Symmetric:
    """R H R^T."""
    one = to_space(body.q, (h[0], h[3], h[4]))
    two = to_space(body.q, (h[3], h[1], h[5]))
    three = to_space(body.q, (h[4], h[5], h[2]))
    # rows of (H R^T)^T are R times the columns of H
    first = to_space(body.q, (one[0], two[0], three[0]))
    second = to_space(body.q, (one[1], two[1], three[1]))
    third = to_space(body.q, (one[2], two[2], three[2]))
    return first[0], second[1], third[2], first[1], first[2], second[2]


@compiled
def seen(p: Vector, body: Body) -> Vector:
    """A point of space along the axes of the body, from its centre."""
    return to_body(body.q, (p[0] - body.x[0], p[1] - body.x[1], p[2] - body.x[2]))


@compiled
def leaves(p: Vector, d: Vector, body: Body) -> float:
    """How far from p, inside the body, along the unit vector d its surface is. Newton on a convex function from beyond: it comes down steadily."""
    u, e = seen(p, body), to_body(body.q, d)
    a, b, c = body.axes
    # the box around the body is left no later than here
    far = 1e300
    for k in range(3):
        if e[k] != 0.0:
            far = min(far, ((body.axes[k] if e[k] > 0.0 else -body.axes[k]) - u[k]) / e[k])
    t = far
    f, g = slope(u, body)
    rate = g[0] * e[0] + g[1] * e[1] + g[2] * e[2]
    if rate > 0.0:
        t = min(t, -f / rate)
    for _ in range(200):
        f, g = slope((u[0] + t * e[0], u[1] + t * e[1], u[2] + t * e[2]), body)
        rate = g[0] * e[0] + g[1] * e[1] + g[2] * e[2]
        step = f / rate
        t -= step
        if not abs(step) > 1e-15 * (a + b + c):
            break
    return t
