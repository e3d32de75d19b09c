"""Richardson: one whole and two half steps of first order, extrapolated; LAMMPS nve/asphere and rigid, LIGGGHTS nve/superquadric scheme 0.

Order 2; keeps the angular momentum in space, the energy drifts with t dt^3.
"""

from __future__ import annotations

from demsolver.algebra import Quat, Vector, compiled, normalised, pushed, spin_of, turned_by


@compiled
def first(q: Quat, angmom: Vector, omega: Vector, torque: Vector, inertia: Vector, h: float) -> tuple[Quat, Vector, Vector]:
    """Orientation of the next step, angular momentum of half a step before it, and spin at the half orientation, which forces see."""
    angmom = pushed(angmom, torque, 0.5 * h)
    omega = spin_of(q, angmom, inertia)
    whole, half = turned_by(q, omega, h), turned_by(q, omega, 0.5 * h)
    omega = spin_of(half, angmom, inertia)
    half = turned_by(half, omega, 0.5 * h)
    q = normalised((2.0 * half[0] - whole[0], 2.0 * half[1] - whole[1], 2.0 * half[2] - whole[2], 2.0 * half[3] - whole[3]))
    return q, angmom, omega


@compiled
def second(q: Quat, angmom: Vector, omega: Vector, torque: Vector, inertia: Vector, h: float) -> tuple[Vector, Vector]:
    """Angular momentum and spin at the end of the step, with its torque."""
    angmom = pushed(angmom, torque, 0.5 * h)
    return angmom, spin_of(q, angmom, inertia)
