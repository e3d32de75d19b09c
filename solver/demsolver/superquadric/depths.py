"""How deep the contacts of a scene with superquadrics are, one by one: for messages, not for the loop."""

from __future__ import annotations

import numpy as np

from demsolver.scene import Scene
from demsolver.state import Floats, Ints, Shaped
from demsolver.superquadric import Body, body, pairs, planes


def body_of(b: Shaped, i: int, x: Floats) -> Body:
    """Particle i, a superquadric or a sphere, with its centre at x (3,)."""
    if b.axes[i, 0] > 0.0:
        return body(x, b.quat[i], b.axes[i], b.blockiness[i])
    return body(x, np.array([1.0, 0.0, 0.0, 0.0]), np.full(3, b.size[i]), np.full(2, 2.0))


def pair_depth(scene: Scene, b: Shaped, i: int, j: int, d: Floats) -> float:
    """Overlap of two particles over what the one of them that reaches less far along the normal reaches, of spheres and by growth over the smaller
    radius; d (3,) from j to i. -inf where they are apart or have no contact point, inf where a centre is beyond it."""
    smaller = min(b.size[i], b.size[j])
    if not (b.axes[i, 0] > 0.0 or b.axes[j, 0] > 0.0):
        return float((b.size[i] + b.size[j] - np.linalg.norm(d)) / smaller) if smaller > 0.0 else np.nan
    one, other = body_of(b, i, np.zeros(3)), body_of(b, j, -d)
    kind = pairs.GAUGE if scene.contact_point == "gauge" else pairs.POTENTIAL
    p, found, _ = pairs.afresh(one, other, kind)
    if not found:
        return -np.inf
    if kind == pairs.GAUGE:
        return float((1.0 - pairs.grown(p, one, other)[0]) * (b.size[i] + b.size[j]) / smaller)
    overlap, n = pairs.chord(p, one, other)
    least = min(-np.dot(p, n), np.dot(p + d, n)) + 0.5 * overlap
    return float(overlap / least if least > 0.0 else np.inf) if overlap > 0.0 else -np.inf


def plane_depths(b: Shaped, i: Ints, n: Floats, way: Floats) -> Floats:
    """(m,) overlaps of particles i with planes, `way` (m,) from their centres against n (m, 3), over how far they reach towards them."""
    reach = b.size[i]
    for k, row in enumerate(i):
        if b.axes[row, 0] > 0.0:
            _, p, normal = planes.touch(tuple(-way[k] * n[k]), body_of(b, int(row), np.zeros(3)))
            reach[k] = -np.dot(p, normal)
    return np.asarray((reach - way) / reach)
