"""Euler's equations by the implicit midpoint rule, the orientation by Cayley's map: LIGGGHTS nve/superquadric scheme 2.

Order 2; keeps the energy to rounding, the direction of the angular momentum swings within dt^2.
"""

from __future__ import annotations

from math import sqrt

from demsolver.algebra import Quat, Vector, compiled, to_body, to_space, turned_in_body

CLOSE = 1e-15
"""Of the spin: iteration ends. LIGGGHTS ends at 1e-12, which with its factor of |omega| dt/4 an iteration is the same to rounding."""
MOST = 200


@compiled
def _advanced(u: Vector, torque: Vector, inertia: Vector, h: float) -> Vector:
    """Spin along the body axes after a time h, u1 = u0 + h I^-1 (T - u x I u) at u = (u0 + u1)/2, iterated; no numbers if it does not converge."""
    new = u
    for _ in range(MOST):
        x, y, z = 0.5 * (u[0] + new[0]), 0.5 * (u[1] + new[1]), 0.5 * (u[2] + new[2])
        last = new
        new = (
            u[0] + h * (torque[0] + (inertia[1] - inertia[2]) * y * z) / inertia[0],
            u[1] + h * (torque[1] + (inertia[2] - inertia[0]) * z * x) / inertia[1],
            u[2] + h * (torque[2] + (inertia[0] - inertia[1]) * x * y) / inertia[2],
        )
        off = (new[0] - last[0]) ** 2 + (new[1] - last[1]) ** 2 + (new[2] - last[2]) ** 2
        if not off > CLOSE**2 * (new[0] ** 2 + new[1] ** 2 + new[2] ** 2):
            return new
    lost = sqrt(-1.0 - off)
    return lost, lost, lost


@compiled
def first(q: Quat, angmom: Vector, omega: Vector, torque: Vector, inertia: Vector, h: float) -> tuple[Quat, Vector, Vector]:
    """Orientation of the next step, and angular momentum and spin of half a step before it in the old orientation; forces see that spin."""
    u = _advanced(to_body(q, omega), to_body(q, torque), inertia, 0.5 * h)
    angmom, omega = to_space(q, (inertia[0] * u[0], inertia[1] * u[1], inertia[2] * u[2])), to_space(q, u)
    return turned_in_body(q, q, u, h), angmom, omega


@compiled
def second(q: Quat, angmom: Vector, omega: Vector, torque: Vector, inertia: Vector, h: float) -> tuple[Vector, Vector]:
    """Angular momentum and spin at the end of the step, with its torque."""
    u = _advanced(to_body(q, omega), to_body(q, torque), inertia, 0.5 * h)
    return to_space(q, (inertia[0] * u[0], inertia[1] * u[1], inertia[2] * u[2])), to_space(q, u)
