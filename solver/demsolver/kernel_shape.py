"""Contact of superquadrics in the loop: a template like kernel.py, compiled once for all scenes.

A pair whose bounding spheres overlap is looked at along a direction: where the two are apart along it, they are apart. Only else is its contact point
asked for, by Newton from where it was, or afresh. What a listed pair remembers of it stands in the columns from g on: what is known (UNKNOWN, a
DIRECTION, a direction and a POINT), the point from the middle between the centres, and the direction, from the partner to the row's particle.

Spheres among them are superquadrics with equal axes; two of them are left to the sphere's own sums.
"""

# ruff: noqa: F821
from math import sqrt

from demsolver.algebra import length, to_body
from demsolver.superquadric import Body
from demsolver.superquadric.pairs import GAUGE as BY_GROWTH
from demsolver.superquadric.pairs import afresh, chord, chord_curvature, grown, newton
from demsolver.superquadric.planes import support, touch
from demsolver.superquadric.surface import curvature, seen

UNKNOWN, DIRECTION, POINT = 0.0, 1.0, 2.0
NOT_FOUND, APART, TOUCHES = -1, 0, 1
NOTHING = (0.0, 0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0)


@compiled
def body_at(b, i, x, y, z):
    """Particle i for the geometry, with its centre there."""
    if b.axes[i, 0] == 0.0:
        r = b.size[i]
        return Body((x, y, z), (1.0, 0.0, 0.0, 0.0), (r, r, r), 2.0, 2.0, 1.0)
    n1, n2 = b.blockiness[i, 0], b.blockiness[i, 1]
    q = b.quat[i, 0], b.quat[i, 1], b.quat[i, 2], b.quat[i, 3]
    return Body((x, y, z), q, (b.axes[i, 0], b.axes[i, 1], b.axes[i, 2]), n1, n2, 2.0 ** (2.0 - max(n1, n2)))


@compiled
def apart_along(n, i, j):
    """Whether there is a gap between the bodies along n, which points from j to i."""
    p, q = support((-n[0], -n[1], -n[2]), i), support(n, j)
    return (p[0] - q[0]) * n[0] + (p[1] - q[1]) * n[1] + (p[2] - q[2]) * n[2] > 0.0


@compiled
def limited(curved, usual, limit):
    """Effective radius by curvature, at most `limit` times the usual."""
    return 1.0 / curved if curved * limit * usual > 1.0 else limit * usual


@compiled
def carried(c, a, o, dx, dy, dz, b, dt):
    """The contact point of the last step, from the middle between the centres: carried on by the material it was in, from particle a."""
    v, w, ma, mo = b.v, b.omega, b.mass[a], b.mass[o]
    share = ma / (ma + mo)
    ax, ay, az = c[0] - 0.5 * dx, c[1] - 0.5 * dy, c[2] - 0.5 * dz
    bx, by, bz = ax + dx, ay + dy, az + dz
    ux = share * (w[a, 1] * az - w[a, 2] * ay) + (1.0 - share) * (w[o, 1] * bz - w[o, 2] * by) + (share - 0.5) * (v[a, 0] - v[o, 0])
    uy = share * (w[a, 2] * ax - w[a, 0] * az) + (1.0 - share) * (w[o, 2] * bx - w[o, 0] * bz) + (share - 0.5) * (v[a, 1] - v[o, 1])
    uz = share * (w[a, 0] * ay - w[a, 1] * ax) + (1.0 - share) * (w[o, 0] * by - w[o, 1] * bx) + (share - 0.5) * (v[a, 2] - v[o, 2])
    return ax + dt * ux, ay + dt * uy, az + dt * uz


@shared
def meet(k, a, o, dx, dy, dz, b, memory, g, how, touched, dt, keep):
    """Contact of a with the image of o, from which d leads to a: state (NOT_FOUND, APART, TOUCHES), overlap, push (kernel_contact.py), normal towards a, the
    contact point from a, effective radius. how: kind of contact (pairs.POTENTIAL, GAUGE), then kind (0: none) and limit of the curvature.
    keep: whether listed pair k remembers what is found. Not for two spheres."""
    i, j = body_at(b, a, 0.0, 0.0, 0.0), body_at(b, o, -dx, -dy, -dz)
    known, n = memory[k, g], (memory[k, g + 4], memory[k, g + 5], memory[k, g + 6])
    if known == UNKNOWN:
        size = sqrt(dx * dx + dy * dy + dz * dz)
        n = dx / size, dy / size, dz / size
    if not touched and apart_along(n, i, j):
        if keep and known == UNKNOWN:
            memory[k, g] = DIRECTION
            for c in range(3):
                memory[k, g + 4 + c] = n[c]
        return APART, *NOTHING
    kind, curved, limit = how
    found = False
    p = (0.0, 0.0, 0.0)
    if known == POINT:
        c = memory[k, g + 1], memory[k, g + 2], memory[k, g + 3]
        p, found, _ = newton(carried(c, a, o, dx, dy, dz, b, dt), i, j, kind)
    if not found:
        p, found, _ = afresh(i, j, kind)
        if not found:
            return NOT_FOUND, *NOTHING
    push = 1.0
    if kind == BY_GROWTH:
        reach = b.size[a] + b.size[o]
        lam, part, n = grown(p, i, j)
        overlap, push = (1.0 - lam) * reach, reach * part
    else:
        overlap, n = chord(p, i, j)
    if keep:
        memory[k, g] = POINT
        memory[k, g + 1], memory[k, g + 2], memory[k, g + 3] = p[0] + 0.5 * dx, p[1] + 0.5 * dy, p[2] + 0.5 * dz
        for c in range(3):
            memory[k, g + 4 + c] = n[c]
    if not overlap > 0.0:
        return APART, *NOTHING
    reff = b.size[a] * b.size[o] / (b.size[a] + b.size[o])
    if curved != 0:
        reff = limited(chord_curvature(p, n, i, j, curved), reff, limit)
    return TOUCHES, overlap, push, n, p, reff


@shared
def meet_plane(i, way, nx, ny, nz, b, kind, limit):
    """Contact of superquadric i with a plane, `way` off its centre against n: overlap, contact point from the centre, effective radius. kind, limit: of its curvature, as
    in `meet`."""
    body = body_at(b, i, 0.0, 0.0, 0.0)
    overlap, p, _ = touch((-way * nx, -way * ny, -way * nz), body)
    reff = b.size[i]
    if kind != 0 and overlap > 0.0:
        reff = limited(curvature(seen(p, body), body, kind), reff, limit)
    return overlap, p[0], p[1], p[2], reff


@shared
def about_point(i, ax, ay, az, wx, wy, wz, b):
    """Moment of inertia of particle i about an axis along w through the point a from its centre, all of its mass at the distance of that."""
    size = sqrt(wx * wx + wy * wy + wz * wz)
    m = b.mass[i]
    own = 0.4 * m * b.size[i] * b.size[i]
    if b.axes[i, 0] > 0.0:
        e = (0.0, 0.0, 1.0)
        if size > 0.0:
            e = to_body((b.quat[i, 0], b.quat[i, 1], b.quat[i, 2], b.quat[i, 3]), (wx / size, wy / size, wz / size))
        own = e[0] * e[0] * b.inertia[i, 0] + e[1] * e[1] * b.inertia[i, 1] + e[2] * e[2] * b.inertia[i, 2]
    return own + m * length((ax, ay, az)) ** 2
