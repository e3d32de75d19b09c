"""NO_SQUISH: exact rotations about one body axis after the other, Miller et al. 2002, doi:10.1063/1.1473654.

LAMMPS fix rigid/nve, LIGGGHTS nve/superquadric scheme 1. Order 2, symplectic; keeps the angular momentum in space, the energy swings within dt^2.
"""

from __future__ import annotations

from math import cos, sin

from demsolver.algebra import Quat, Vector, compiled, normalised, product, pushed, spin_of, to_body, to_space


@compiled
def _about_x(q: Quat, p: Quat, inertia: float, h: float) -> tuple[Quat, Quat]:
    a, b = (-q[1], q[0], q[3], -q[2]), (-p[1], p[0], p[3], -p[2])
    return _about(q, p, a, b, inertia, h)


@compiled
def _about_y(q: Quat, p: Quat, inertia: float, h: float) -> tuple[Quat, Quat]:
    a, b = (-q[2], -q[3], q[0], q[1]), (-p[2], -p[3], p[0], p[1])
    return _about(q, p, a, b, inertia, h)


@compiled
def _about_z(q: Quat, p: Quat, inertia: float, h: float) -> tuple[Quat, Quat]:
    a, b = (-q[3], q[2], -q[1], q[0]), (-p[3], p[2], -p[1], p[0])
    return _about(q, p, a, b, inertia, h)


@compiled
def _about(q: Quat, p: Quat, a: Quat, b: Quat, inertia: float, h: float) -> tuple[Quat, Quat]:
    """a, b: q and p times the unit quaternion of the axis."""
    angle = h * (p[0] * a[0] + p[1] * a[1] + p[2] * a[2] + p[3] * a[3]) / (4.0 * inertia)
    c, s = cos(angle), sin(angle)
    return (
        (c * q[0] + s * a[0], c * q[1] + s * a[1], c * q[2] + s * a[2], c * q[3] + s * a[3]),
        (c * p[0] + s * b[0], c * p[1] + s * b[1], c * p[2] + s * b[2], c * p[3] + s * b[3]),
    )


@compiled
def first(q: Quat, angmom: Vector, omega: Vector, torque: Vector, inertia: Vector, h: float) -> tuple[Quat, Vector, Vector]:
    """Orientation of the next step, and angular momentum and spin of half a step before it, which forces see."""
    angmom = pushed(angmom, torque, 0.5 * h)
    m = to_body(q, angmom)
    p = product(q, (0.0, 2.0 * m[0], 2.0 * m[1], 2.0 * m[2]))
    q, p = _about_z(q, p, inertia[2], 0.5 * h)
    q, p = _about_y(q, p, inertia[1], 0.5 * h)
    q, p = _about_x(q, p, inertia[0], h)
    q, p = _about_y(q, p, inertia[1], 0.5 * h)
    q, p = _about_z(q, p, inertia[2], 0.5 * h)
    q = normalised(q)
    _, x, y, z = product((q[0], -q[1], -q[2], -q[3]), p)
    m = 0.5 * x, 0.5 * y, 0.5 * z
    return q, to_space(q, m), to_space(q, (m[0] / inertia[0], m[1] / inertia[1], m[2] / inertia[2]))


@compiled
def second(q: Quat, angmom: Vector, omega: Vector, torque: Vector, inertia: Vector, h: float) -> tuple[Vector, Vector]:
    """Angular momentum and spin at the end of the step, with its torque."""
    angmom = pushed(angmom, torque, 0.5 * h)
    return angmom, spin_of(q, angmom, inertia)
