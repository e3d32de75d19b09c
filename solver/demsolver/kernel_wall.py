"""Contact of one particle with one wall: a template like kernel.py, of which every wall gets a copy with its own law and arms bound.

Here `wall_contact` is the wall's law; SURFACE_CONTACT and TORQUE_CONTACT say where its arms end: True at the contact point, False at R.
(A compiled function that took the law as an argument could not be cached.)
"""

# ruff: noqa: F821


@inlined
def wall_force(i, nx, ny, nz, overlap, reff, wvx, wvy, wvz, turning, b, memory, coefficients, dt, advance, tally):
    """Contact of particle i with one wall whose normal (towards the particle), overlap, surface velocity and angular velocity are given."""
    w = b.omega
    if GUARD and overlap > DEEPEST * b.radius[i]:
        tally[6] += 1.0
    vx, vy, vz = b.v[i, 0] - wvx, b.v[i, 1] - wvy, b.v[i, 2] - wvz
    vn = vx * nx + vy * ny + vz * nz
    arm = b.radius[i] - 0.5 * overlap if SURFACE_CONTACT else b.radius[i]
    tx = vx - vn * nx - arm * (w[i, 1] * nz - w[i, 2] * ny)
    ty = vy - vn * ny - arm * (w[i, 2] * nx - w[i, 0] * nz)
    tz = vz - vn * nz - arm * (w[i, 0] * ny - w[i, 1] * nx)
    fn, damping, fx, fy, fz, rx, ry, rz, shift, loss = wall_contact(
        memory, i, overlap, b.radius[i], 0.0, reff, b.mass[i], ROLLING_INERTIA * b.mass[i] * b.radius[i] * b.radius[i],
        (b.radius[i] - 0.5 * overlap) / (b.radius[i] - overlap), vn, nx, ny, nz, tx, ty, tz,
        w[i, 0] - turning[0], w[i, 1] - turning[1], w[i, 2] - turning[2], dt, advance, coefficients, b.kind[i],
    )
    arm = b.radius[i] - 0.5 * overlap if TORQUE_CONTACT else b.radius[i]
    qx, qy, qz = -arm * (ny * fz - nz * fy), -arm * (nz * fx - nx * fz), -arm * (nx * fy - ny * fx)
    b.force[i, 0] += fn * nx + fx
    b.force[i, 1] += fn * ny + fy
    b.force[i, 2] += fn * nz + fz
    b.torque[i, 0] += qx + rx
    b.torque[i, 1] += qy + ry
    b.torque[i, 2] += qz + rz
    if IMPLICIT:
        b.aside[i, 0] += (fn - damping) * nx
        b.aside[i, 1] += (fn - damping) * ny
        b.aside[i, 2] += (fn - damping) * nz
    if SHIFTING:
        b.aside[i, 0] += shift * nx
        b.aside[i, 1] += shift * ny
        b.aside[i, 2] += shift * nz
        if advance:
            tally[0] -= loss
    if BUDGET:
        push = (fn - damping) * (nx * wvx + ny * wvy + nz * wvz)
        now = (damping * nx, damping * ny, damping * nz, fx, fy, fz, qx, qy, qz, 0.0, 0.0, 0.0, rx, ry, rz, -rx, -ry, -rz, push)
        if advance:
            spend(memory, i, BASE, now, vx, vy, vz, w[i], turning, 0.5 * dt, tally)
            drive(memory, i, BASE, now, wvx, wvy, wvz, turning, 0.5 * dt, tally)
        remember(memory, i, BASE, now)
