"""Angular momentum of half steps by leapfrog, as in Fincham's scheme: LIGGGHTS nve/superquadric scheme 3, with its fault.

The spin of the whole step is taken from the angular momentum along the body axes of the old orientation, not of the half one, so its order is 1.
"""

from __future__ import annotations

from demsolver.algebra import Quat, Vector, compiled, pushed, to_body, to_space, turned_in_body


@compiled
def first(q: Quat, angmom: Vector, omega: Vector, torque: Vector, inertia: Vector, h: float) -> tuple[Quat, Vector, Vector]:
    """Orientation and spin of the next step, angular momentum of half a step before it."""
    m = to_body(q, pushed(angmom, torque, 0.5 * h))
    angmom = pushed(angmom, torque, h)
    n = to_body(q, angmom)
    u = n[0] / inertia[0], n[1] / inertia[1], n[2] / inertia[2]
    half = turned_in_body(q, q, (m[0] / inertia[0], m[1] / inertia[1], m[2] / inertia[2]), 0.5 * h)
    q = turned_in_body(q, half, u, h)
    return q, angmom, to_space(q, u)


@compiled
def second(q: Quat, angmom: Vector, omega: Vector, torque: Vector, inertia: Vector, h: float) -> tuple[Vector, Vector]:
    """Nothing: the angular momentum stays that of half a step before."""
    return angmom, omega
