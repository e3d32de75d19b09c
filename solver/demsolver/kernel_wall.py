"""Contact of one particle with one wall: a template like kernel.py, of which every wall gets a copy with its own law and arms bound.

Here `wall_contact` is the wall's law; SURFACE_CONTACT and TORQUE_CONTACT say where the arms of spheres end: True at the contact point, False at R.
(A compiled function that took the law as an argument could not be cached.)
"""

# ruff: noqa: F821


@inlined
def wall_force(i, nx, ny, nz, overlap, reff, ax, ay, az, round_, wvx, wvy, wvz, turning, b, memory, coefficients, dt, advance, tally):
    """Contact of particle i with one wall whose normal (towards the particle), overlap, surface velocity and angular velocity are given; of a superquadric (not
    round_) also the contact point a from its centre."""
    w = b.omega
    radius, mass = rough_size(b, i), heft(b, i)
    if GUARD and overlap > DEEPEST * (radius if not SHAPES or round_ else -(ax * nx + ay * ny + az * nz)):
        tally[6] += 1.0
    vx, vy, vz = b.v[i, 0] - wvx, b.v[i, 1] - wvy, b.v[i, 2] - wvz
    inertia, ratio = ROLLING_INERTIA * mass * radius * radius, (radius - 0.5 * overlap) / (radius - overlap)
    if SHAPES and not round_:
        inertia, ratio = about_point(i, ax, ay, az, w[i, 0] - turning[0], w[i, 1] - turning[1], w[i, 2] - turning[2], b), 1.0
        tx, ty, tz = vx + w[i, 1] * az - w[i, 2] * ay, vy + w[i, 2] * ax - w[i, 0] * az, vz + w[i, 0] * ay - w[i, 1] * ax
        vn = tx * nx + ty * ny + tz * nz
        tx, ty, tz = tx - vn * nx, ty - vn * ny, tz - vn * nz
    else:
        vn = vx * nx + vy * ny + vz * nz
        arm = radius - 0.5 * overlap if SURFACE_CONTACT else radius
        tx = vx - vn * nx - arm * (w[i, 1] * nz - w[i, 2] * ny)
        ty = vy - vn * ny - arm * (w[i, 2] * nx - w[i, 0] * nz)
        tz = vz - vn * nz - arm * (w[i, 0] * ny - w[i, 1] * nx)
    fn, damping, fx, fy, fz, rx, ry, rz, shift, loss = wall_contact(
        memory, i, overlap, radius, 0.0, reff, mass, inertia, ratio, vn, nx, ny, nz, tx, ty, tz,
        w[i, 0] - turning[0], w[i, 1] - turning[1], w[i, 2] - turning[2], dt, advance, 1.0, coefficients, b.kind[i],
    )
    dqx = dqy = dqz = 0.0  # of the normal force
    if SHAPES and not round_:
        qx, qy, qz = ay * fz - az * fy, az * fx - ax * fz, ax * fy - ay * fx
        dqx, dqy, dqz = ay * nz - az * ny, az * nx - ax * nz, ax * ny - ay * nx
    else:
        arm = radius - 0.5 * overlap if TORQUE_CONTACT else radius
        qx, qy, qz = -arm * (ny * fz - nz * fy), -arm * (nz * fx - nx * fz), -arm * (nx * fy - ny * fx)
    b.force[i, 0] += fn * nx + fx
    b.force[i, 1] += fn * ny + fy
    b.force[i, 2] += fn * nz + fz
    b.torque[i, 0] += qx + rx
    b.torque[i, 1] += qy + ry
    b.torque[i, 2] += qz + rz
    if SHAPES:
        b.torque[i, 0] += fn * dqx
        b.torque[i, 1] += fn * dqy
        b.torque[i, 2] += fn * dqz
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
        if SHAPES:
            now = now + (damping * dqx, damping * dqy, damping * dqz, 0.0, 0.0, 0.0)
        if advance:
            spend(memory, i, BASE, now, vx, vy, vz, w[i], turning, 0.5 * dt, tally)
            drive(memory, i, BASE, now, wvx, wvy, wvz, turning, 0.5 * dt, tally)
        remember(memory, i, BASE, now)
