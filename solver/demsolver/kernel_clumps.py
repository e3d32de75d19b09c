"""How clumps move: a template like kernel.py, compiled once for all scenes with the same constants.

What acts on the members is gathered, the whole moves by half steps as a single particle does, and the members are put where it then is. A member's way in a step
is no straight line: what the near list is told of it is how far it departs from its velocity before and after, as a change of velocity.

first, second: halves of a step of the scheme of the clumps (demsolver.rotation).
"""

# ruff: noqa: F821
from math import sqrt

from demsolver.algebra import to_space
from demsolver.rotation.CLUMP_SCHEME import first as clump_first
from demsolver.rotation.CLUMP_SCHEME import second as clump_second


ONLY_SPEEDS, ON = 1, 2  # how members are put in place: their velocities alone, or places too


@compiled
def gather_clump(m, b, c):
    """Force and torque on clump m from its members."""
    x, y, z = c.x[m, 0], c.x[m, 1], c.x[m, 2]
    fx = fy = fz = tx = ty = tz = 0.0
    for k in range(c.first[m], c.first[m + 1]):
        i = c.member[k]
        f0, f1, f2 = b.force[i, 0], b.force[i, 1], b.force[i, 2]
        a0, a1, a2 = b.x[i, 0] - c.home[k, 0] - x, b.x[i, 1] - c.home[k, 1] - y, b.x[i, 2] - c.home[k, 2] - z
        fx, fy, fz = fx + f0, fy + f1, fz + f2
        tx += a1 * f2 - a2 * f1
        ty += a2 * f0 - a0 * f2
        tz += a0 * f1 - a1 * f0
        if ROTATES:
            tx, ty, tz = tx + b.torque[i, 0], ty + b.torque[i, 1], tz + b.torque[i, 2]
    c.force[m, 0], c.force[m, 1], c.force[m, 2] = fx + c.mass[m] * c.weight[m, 0], fy + c.mass[m] * c.weight[m, 1], fz + c.mass[m] * c.weight[m, 2]
    c.torque[m, 0], c.torque[m, 1], c.torque[m, 2] = tx, ty, tz


@compiled
def place_clump(m, how, b, c, dt):
    """Puts the members where the clump is; returns the largest squared departure of one from its velocity."""
    q, w = (c.quat[m, 0], c.quat[m, 1], c.quat[m, 2], c.quat[m, 3]), (c.omega[m, 0], c.omega[m, 1], c.omega[m, 2])
    most = 0.0
    for k in range(c.first[m], c.first[m + 1]):
        i = c.member[k]
        r = to_space(q, (c.offset[k, 0], c.offset[k, 1], c.offset[k, 2]))
        v = c.v[m, 0] + w[1] * r[2] - w[2] * r[1], c.v[m, 1] + w[2] * r[0] - w[0] * r[2], c.v[m, 2] + w[0] * r[1] - w[1] * r[0]
        before = after = 0.0
        for d in range(3):
            if how == ON:
                at = c.x[m, d] + r[d] + c.home[k, d]
                mean = (at - b.x[i, d]) / dt
                before += (mean - b.v[i, d]) ** 2
                after += (v[d] - mean) ** 2
                b.x[i, d] = at
            b.v[i, d] = v[d]
            if ROTATES:
                b.omega[i, d] = w[d]
        most = max(most, (sqrt(before) + sqrt(after)) ** 2)
    return most


@shared
def move_clumps(gathers, ends, begins, b, c, dt):
    """Forces on the clumps, the end of a step, the begin of the next: whichever is asked for. Returns as place_clump."""
    most = 0.0
    h = 0.5 * dt
    for m in range(c.mass.shape[0]):
        if gathers:
            gather_clump(m, b, c)
        q, angmom = (c.quat[m, 0], c.quat[m, 1], c.quat[m, 2], c.quat[m, 3]), (c.angmom[m, 0], c.angmom[m, 1], c.angmom[m, 2])
        omega, torque = (c.omega[m, 0], c.omega[m, 1], c.omega[m, 2]), (c.torque[m, 0], c.torque[m, 1], c.torque[m, 2])
        inertia, k = (c.inertia[m, 0], c.inertia[m, 1], c.inertia[m, 2]), h / c.mass[m]
        if ends:
            angmom, omega = clump_second(q, angmom, omega, torque, inertia, dt)
            for d in range(3):
                c.v[m, d] += k * c.force[m, d]
        if begins:
            q, angmom, omega = clump_first(q, angmom, omega, torque, inertia, dt)
            c.quat[m, 0], c.quat[m, 1], c.quat[m, 2], c.quat[m, 3] = q
            for d in range(3):
                c.v[m, d] += k * c.force[m, d]
                c.x[m, d] += dt * c.v[m, d]
        for d in range(3):
            c.angmom[m, d], c.omega[m, d] = angmom[d], omega[d]
        if begins or ends:
            most = max(most, place_clump(m, ON if begins else ONLY_SPEEDS, b, c, dt))
    return most
