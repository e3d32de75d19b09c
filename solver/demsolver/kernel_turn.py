"""How superquadrics turn: a template like kernel.py, compiled once for all scenes with the same constants.

first, second: halves of a step of the scheme of the scene (demsolver.rotation).
"""

# ruff: noqa: F821
from demsolver.rotation.SCHEME import first, second

TURN_FIRST, TURN_SECOND, TURN_BOTH = 0, 1, 2


@shared
def turn(low, high, part, b, dt):
    """The superquadrics low..high turn: the second half of this step, and (TURN_BOTH) the first of the next, or that alone."""
    for i in range(low, high):
        if b.axes[i, 0] == 0.0:
            continue
        q = b.quat[i, 0], b.quat[i, 1], b.quat[i, 2], b.quat[i, 3]
        angmom = b.angmom[i, 0], b.angmom[i, 1], b.angmom[i, 2]
        omega = b.omega[i, 0], b.omega[i, 1], b.omega[i, 2]
        torque = b.torque[i, 0], b.torque[i, 1], b.torque[i, 2]
        inertia = b.inertia[i, 0], b.inertia[i, 1], b.inertia[i, 2]
        if part != TURN_FIRST:
            angmom, omega = second(q, angmom, omega, torque, inertia, dt)
        if part != TURN_SECOND:
            q, angmom, omega = first(q, angmom, omega, torque, inertia, dt)
            b.quat[i, 0], b.quat[i, 1], b.quat[i, 2], b.quat[i, 3] = q
        for c in range(3):
            b.angmom[i, c], b.omega[i, c] = angmom[c], omega[c]
