"""The account of energy of the contacts: a template like kernel.py, behind kernel_contact.py.

Memory columns of a contact: first BASE columns of the law's own; with BUDGET also what took energy in the last step, BOOKS columns: three each
of the normal damping force, the tangential force, its torques on both sides, the rolling torques on both sides; the power that a wall's motion gives
to the spring; with SHAPES the torques of the damping force on both sides. Behind them, from GEOMETRY on, what kernel_shape.py remembers.
Tally: 0 work of the normal damping, 1 work of the tangential force, 2 work of viscous drag, 4 work of the rolling torques; negative while they
take energy; 5 work of the walls' motion on the particles; 6 contacts that were deeper than DEEPEST of the smaller radius (GUARD); 7 contacts of superquadrics whose
point was not found. With VIRIAL: 3 the sum of r.F over the pairs of the last force evaluation. A row a chunk.
"""

# ruff: noqa: F821

REST = (0.0,) * BOOKS  # `now` of a contact that has ended


@compiled
def spend(memory, k, base, now, vx, vy, vz, wi, wj, half_dt, tally):
    """Work of one step on a contact by the trapezoid rule (order dt^2): half by the forces of the last step, half by today's `now`.

    wi, wj: (3,) angular velocities of both sides.
    """
    tally[0] += half_dt * (
        (memory[k, base] + now[0]) * vx + (memory[k, base + 1] + now[1]) * vy + (memory[k, base + 2] + now[2]) * vz
    )
    rubbing = (memory[k, base + 3] + now[3]) * vx + (memory[k, base + 4] + now[4]) * vy + (memory[k, base + 5] + now[5]) * vz
    rolling = 0.0
    for c in range(3):
        rubbing += (memory[k, base + 6 + c] + now[6 + c]) * wi[c] + (memory[k, base + 9 + c] + now[9 + c]) * wj[c]
        rolling += (memory[k, base + 12 + c] + now[12 + c]) * wi[c] + (memory[k, base + 15 + c] + now[15 + c]) * wj[c]
    if SHAPES:
        for c in range(3):
            tally[0] += half_dt * ((memory[k, base + 19 + c] + now[19 + c]) * wi[c] + (memory[k, base + 22 + c] + now[22 + c]) * wj[c])
    tally[1] += half_dt * rubbing
    tally[4] += half_dt * rolling


@compiled
def drive(memory, k, base, now, ux, uy, uz, turning, half_dt, tally):
    """Work that a wall does in one step by its motion, by the same rule. u: its velocity where it is touched; turning: (3,) angular velocity."""
    driving = memory[k, base + 18] + now[18]
    driving += (memory[k, base] + now[0] + memory[k, base + 3] + now[3]) * ux
    driving += (memory[k, base + 1] + now[1] + memory[k, base + 4] + now[4]) * uy
    driving += (memory[k, base + 2] + now[2] + memory[k, base + 5] + now[5]) * uz
    for c in range(3):
        driving += (memory[k, base + 12 + c] + now[12 + c]) * turning[c]
    tally[5] += half_dt * driving


@compiled
def remember(memory, k, base, now):
    """Keep today's forces for the work of the next step."""
    for c in range(BOOKS):
        memory[k, base + c] = now[c]


@compiled
def settle(memory, k, base, vx, vy, vz, wi, wj, half_dt, advance, tally):
    """The last work on a contact that has ended."""
    if advance:
        spend(memory, k, base, REST, vx, vy, vz, wi, wj, half_dt, tally)
    remember(memory, k, base, REST)


@inlined
def torques(u, fx, fy, fz, nx, ny, nz, ra, ro, lanes):
    """What a part of the force makes of torque on both."""
    ax, ay, az, bx, by, bz = arms(u, nx, ny, nz, ra, ro, lanes[OVERLAP + u], TORQUE_CONTACT, lanes)
    return ay * fz - az * fy, az * fx - ax * fz, ax * fy - ay * fx, bz * fy - by * fz, bx * fz - bz * fx, by * fx - bx * fy


@compiled
def keep_books(u, k, a, o, both, nx, ny, nz, b, p, dt, advance, tally, lanes):
    """The work that the contact in lane u has taken in this step."""
    half_dt = 0.5 * dt if both else 0.25 * dt  # half a pair: the other half stands beside it, as seen from there
    damping = lanes[DAMPING + u]
    qx, qy, qz = lanes[QX + u], lanes[QY + u], lanes[QZ + u]
    ra, ro = rough_size(b, a), rough_size(b, o)
    share = pair_rolling_share(ra, ro) if ROLLING else 1.0
    gx = gy = gz = hx = hy = hz = 0.0
    if SHAPES:
        gx, gy, gz, hx, hy, hz = torques(u, lanes[FX + u], lanes[FY + u], lanes[FZ + u], nx, ny, nz, ra, ro, lanes)
    elif FRICTION or ROLLING:
        gx, gy, gz = lanes[GX + u] - qx, lanes[GY + u] - qy, lanes[GZ + u] - qz
        hx, hy, hz = lanes[TORQUE[0] + u] + share * qx, lanes[TORQUE[1] + u] + share * qy, lanes[TORQUE[2] + u] + share * qz
    now = (
        damping * nx, damping * ny, damping * nz, lanes[FX + u], lanes[FY + u], lanes[FZ + u], gx, gy, gz, hx, hy, hz,
        qx, qy, qz, -share * qx, -share * qy, -share * qz, 0.0,
    )
    if SHAPES:
        now = now + torques(u, damping * nx, damping * ny, damping * nz, nx, ny, nz, ra, ro, lanes)
    if advance:
        spend(p.memory, k, BASE, now, lanes[VX + u], lanes[VY + u], lanes[VZ + u], b.omega[a], b.omega[o], half_dt, tally)
    remember(p.memory, k, BASE, now)
