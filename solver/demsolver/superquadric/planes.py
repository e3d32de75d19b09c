"""Contact with a plane: the point of the body that is farthest beyond it, in closed form."""

from __future__ import annotations

from demsolver.algebra import Vector, compiled, to_body, to_space
from demsolver.superquadric import Body
from demsolver.superquadric.surface import power


@compiled
def support(d: Vector, body: Body) -> Vector:
    """The point of the surface, in space, that lies farthest along d (of any length but 0): there the gradient is along d.

    With m = R^T d: |u_i| = a_i t (1, al, be), the first for the larger of |m_x a|, |m_y b|."""
    m, (a, b, c), n1, n2 = to_body(body.q, d), body.axes, body.n1, body.n2
    mx, my, mz = abs(m[0]) * a, abs(m[1]) * b, abs(m[2]) * c
    most, least = max(mx, my), min(mx, my)
    if most == 0.0:
        return _place((0.0, 0.0, c if m[2] >= 0.0 else -c), body)
    al = power(least / most, 1.0 / (n2 - 1.0))
    whole = 1.0 + power(al, n2)
    wide = whole ** (n1 / n2)
    be = power(mz / most * wide / whole, 1.0 / (n1 - 1.0))
    t = (wide + power(be, n1)) ** (-1.0 / n1)
    x, y = (t, al * t) if mx >= my else (al * t, t)
    return _place((a * x if m[0] >= 0.0 else -a * x, b * y if m[1] >= 0.0 else -b * y, c * be * t if m[2] >= 0.0 else -c * be * t), body)


@compiled
def _place(u: Vector, body: Body) -> Vector:
    v = to_space(body.q, u)
    return body.x[0] + v[0], body.x[1] + v[1], body.x[2] + v[2]


@compiled
def touch(foot: Vector, body: Body) -> tuple[float, Vector, Vector]:
    """Overlap with a plane (above 0: contact), contact point on the body, unit normal towards its centre. foot: the plane's point that is nearest to
    the centre. A centre beyond the plane is pushed out on its own side."""
    d = foot[0] - body.x[0], foot[1] - body.x[1], foot[2] - body.x[2]
    far = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) ** 0.5
    p = support(d, body)
    n = -d[0] / far, -d[1] / far, -d[2] / far
    beyond = -(n[0] * (p[0] - foot[0]) + n[1] * (p[1] - foot[1]) + n[2] * (p[2] - foot[2]))
    return beyond, p, n
