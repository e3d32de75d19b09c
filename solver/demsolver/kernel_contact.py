"""One contact, and what it does to its two particles: a template like kernel.py, in front of it.

Pairs are done in blocks: `look`, `gather`, `act` (the law), `deliver`, `give`. kernel_wall.py holds walls, kernel_shape.py the geometry of superquadrics, kernel_books.py
the account of energy and where it is remembered.

push (SHAPES): what the laws call the overlap grows by push times the way along the normal, so that force times way is what the spring stores.
"""

# ruff: noqa: F821
from math import sqrt

import numpy as np

# Fields of a block of contacts: field F of lane u is lanes[F + u], so that the arithmetic of several contacts is done at once. What the
# law remembers stands apart, in `past`, column c of lane u at past[c * BLOCK + u]: it is state, and keeps all its digits in mixed precision too.
(
    DX, DY, DZ, VX, VY, VZ, WAX, WAY, WAZ, WOX, WOY, WOZ, RA, RO, MEFF, INERTIA,
    NX, NY, NZ, PX, PY, PZ, GX, GY, GZ, HX, HY, HZ, SPRING, DAMPING, FX, FY, FZ, QX, QY, QZ, SHIFT, LOSS,
    OVERLAP, PUSH, AX, AY, AZ, REFF, ROUND,
) = (np.uint64(BLOCK * number) for number in range(FIELDS))
# The same of whole numbers: who feels it, the other, whether both do, place in the list of all pairs, row of the table of coefficients.
FELT, OTHER, BOTH, ENTRY, LAW = (np.uint64(BLOCK * number) for number in range(5))
TORQUE = (GX, GY, GZ) if SAME_TORQUE else (HX, HY, HZ)  # on the other
# Places are unsigned throughout: of a signed one Numba asks whether it counts from the end.

@inlined
def feels(q, near):
    """Who feels entry q, the other, the shift between them, and whether both feel it."""
    i, j = np.uint64(near.row[q]), np.uint64(near.partner[q])
    if PERIODIC:
        s = np.int64(near.code[q])
        if s >= PARTNER_FEELS:
            return j, i, s - PARTNER_FEELS, False
        return i, j, s, s == HOME
    return i, j, HOME, True


@inlined
def between(a, o, s, x, shifts):
    """Vector from the image of o to a."""
    if PERIODIC and s != HOME:
        return x[a, 0] - (x[o, 0] + shifts[s, 0]), x[a, 1] - (x[o, 1] + shifts[s, 1]), x[a, 2] - (x[o, 2] + shifts[s, 2])
    return x[a, 0] - x[o, 0], x[a, 1] - x[o, 1], x[a, 2] - x[o, 2]


@inlined
def look(q, u, b, p, near, shifts, equal, coefficients, ntypes, dt, advance, tally, lanes, who):
    """Entry q goes into lane u; returns whether it touches, 1 or 0. A contact that has ended is settled.

    Whether a near pair touches is hard to foretell: nothing here asks, so that a lane that does not touch is just taken by the next.
    """
    a, o, s, both = feels(q, near)
    k = np.uint64(near.entry[q])
    dx, dy, dz = between(a, o, s, b.x, shifts)
    lanes[DX + u], lanes[DY + u], lanes[DZ + u] = dx, dy, dz
    who[FELT + u], who[OTHER + u], who[BOTH + u], who[ENTRY + u] = a, o, both, k
    ra, ro = (equal[0], equal[0]) if UNIFORM else (b.radius[a], b.radius[o])
    reach = ra + ro
    beyond = reach
    if BEYOND and p.touching[k] & 1:
        beyond += pair_reach(ra * ro / reach, coefficients, 0 if ONE_LAW else b.kind[a] * ntypes + b.kind[o])
    touches = np.uint64(dx * dx + dy * dy + dz * dz < beyond * beyond)
    if SHAPES and touches != 0:
        touches = look_closer(u, k, a, o, dx, dy, dz, b, p, dt if advance else 0.0, tally, lanes)
    if (p.touching[k] & np.uint64(1)) > touches:
        end_contact(k, a, o, both, reach - beyond, b, p, equal, coefficients, ntypes, dt, advance, tally)
    return touches


@compiled
def look_closer(u, k, a, o, dx, dy, dz, b, p, dt, tally, lanes):
    """Whether two touch whose bounding spheres do; their geometry goes into lane u. In lanes A: the contact point from a; of two spheres nothing."""
    if b.axes[a, 0] == 0.0 and b.axes[o, 0] == 0.0:
        reach, distance = b.size[a] + b.size[o], sqrt(dx * dx + dy * dy + dz * dz)
        lanes[NX + u], lanes[NY + u], lanes[NZ + u] = dx / distance, dy / distance, dz / distance
        lanes[OVERLAP + u], lanes[PUSH + u], lanes[REFF + u], lanes[ROUND + u] = reach - distance, 1.0, b.size[a] * b.size[o] / reach, 1.0
        return np.uint64(1)
    state, overlap, push, n, arm, reff = meet(k, a, o, dx, dy, dz, b, p.memory, GEOMETRY, SHAPE_CONTACT, p.touching[k] & 1 != 0, dt, True)
    if state == NOT_FOUND:
        tally[7] += 1.0
    lanes[NX + u], lanes[NY + u], lanes[NZ + u] = n
    lanes[AX + u], lanes[AY + u], lanes[AZ + u] = arm
    lanes[OVERLAP + u], lanes[PUSH + u], lanes[REFF + u], lanes[ROUND + u] = overlap, push, reff, 0.0
    return np.uint64(state == TOUCHES)


@inlined
def heft(b, i):
    """The mass that contacts of particle i see."""
    return b.heft[i] if CLUMPS else b.mass[i]


@inlined
def rough_size(b, i):
    """Its radius, or that of a sphere of the same volume."""
    return b.size[i] if SHAPES else b.radius[i]


@compiled
def end_contact(k, a, o, both, overlap, b, p, equal, coefficients, ntypes, dt, advance, tally):
    """The two of listed pair k have parted, at this overlap (below zero of laws that hold on to each other)."""
    half_dt = 0.5 * dt if both else 0.25 * dt
    v, w = b.v, b.omega
    if BUDGET and BEYOND and advance:  # what a contact holds where it snaps off
        ri, rj = (equal[0], equal[0]) if UNIFORM else (b.radius[a], b.radius[o])
        row = 0 if ONE_LAW else b.kind[a] * ntypes + b.kind[o]
        held = pair_stored(p.memory, k, overlap, ri, 1.0 / rj, ri * rj / (ri + rj), 0.0, 0.0, dt, coefficients, row)
        tally[0] -= held[0] if both else 0.5 * held[0]
    if BUDGET:
        settle(p.memory, k, BASE, v[a, 0] - v[o, 0], v[a, 1] - v[o, 1], v[a, 2] - v[o, 2], w[a], w[o], half_dt, advance, tally)
    if not OUTLIVES:
        for c in range(BASE):
            p.memory[k, c] = 0.0
    p.touching[k] = 2 if OUTLIVES else 0


@inlined
def gather(u, b, p, equal, ntypes, lanes, past, who):
    """Lane u, which touches, gets the rest of what the law asks. equal: radius and mass of all (UNIFORM)."""
    a, o, k = np.uint64(who[FELT + u]), np.uint64(who[OTHER + u]), np.uint64(who[ENTRY + u])
    p.touching[k] = 3 if OUTLIVES else 1
    lanes[VX + u], lanes[VY + u], lanes[VZ + u] = b.v[a, 0] - b.v[o, 0], b.v[a, 1] - b.v[o, 1], b.v[a, 2] - b.v[o, 2]
    if TORQUES:
        lanes[WAX + u], lanes[WAY + u], lanes[WAZ + u] = b.omega[a, 0], b.omega[a, 1], b.omega[a, 2]
        lanes[WOX + u], lanes[WOY + u], lanes[WOZ + u] = b.omega[o, 0], b.omega[o, 1], b.omega[o, 2]
    if not UNIFORM:
        lanes[RA + u], lanes[RO + u] = rough_size(b, a), rough_size(b, o)
    if FROZEN or not UNIFORM:
        ma, mo = (equal[1], equal[1]) if UNIFORM else (heft(b, a), heft(b, o))
        meff = ma * mo / (ma + mo)
        if FROZEN:
            meff = mo if b.frozen[a] else (ma if b.frozen[o] else meff)
        lanes[MEFF + u] = meff
    if SHAPES and ROLLING and lanes[ROUND + u] == 0.0:
        ax, ay, az = lanes[AX + u], lanes[AY + u], lanes[AZ + u]
        wx, wy, wz = b.omega[a, 0] - b.omega[o, 0], b.omega[a, 1] - b.omega[o, 1], b.omega[a, 2] - b.omega[o, 2]
        own = about_point(a, ax, ay, az, wx, wy, wz, b)
        other = about_point(o, ax + lanes[DX + u], ay + lanes[DY + u], az + lanes[DZ + u], wx, wy, wz, b)
        lanes[INERTIA + u] = 1.0 / (1.0 / own + 1.0 / other)
    elif ROLLING and not UNIFORM:
        lanes[INERTIA + u] = rolling_inertia(heft(b, a), rough_size(b, a), heft(b, o), rough_size(b, o))
    if not ONE_LAW:
        who[LAW + u] = b.kind[a] * ntypes + b.kind[o]
    for c in range(BASE):
        past[np.uint64(c * BLOCK) + u] = p.memory[k, c]


@inlined
def arms(u, nx, ny, nz, ra, ro, overlap, to_contact, lanes):
    """From a, and from o, to where they touch in lane u; of two spheres as far as the law says."""
    if lanes[ROUND + u] != 0.0:
        aa, ao = (ra - 0.5 * overlap, ro - 0.5 * overlap) if to_contact else (ra, ro)
        return -aa * nx, -aa * ny, -aa * nz, ao * nx, ao * ny, ao * nz
    ax, ay, az = lanes[AX + u], lanes[AY + u], lanes[AZ + u]
    return ax, ay, az, ax + lanes[DX + u], ay + lanes[DY + u], az + lanes[DZ + u]


@inlined
def rolling_inertia(ma, ra, mo, ro):
    """Of the two about their contact point."""
    return ROLLING_INERTIA / (1.0 / (ma * ra * ra) + 1.0 / (mo * ro * ro))


@compiled
def act(count, equal, coefficients, dt, advance, lanes, past, who):
    """The law in the lanes 0..count: force P on who feels it, torques G on it and H on the other, and what the books want to know. Returns how many
    are too deep."""
    deep = NOBODY
    for u in range(min(count, np.uint64(BLOCK))):
        dx, dy, dz = lanes[DX + u], lanes[DY + u], lanes[DZ + u]
        ra, ro = (equal[0], equal[0]) if UNIFORM else (lanes[RA + u], lanes[RO + u])
        meff = lanes[MEFF + u] if FROZEN or not UNIFORM else equal[1] * equal[1] / (equal[1] + equal[1])
        row = 0 if ONE_LAW else who[LAW + u]
        reach = ra + ro
        ax = ay = az = bx = by = bz = 0.0
        push = 1.0
        if SHAPES:
            nx, ny, nz, overlap, push, reff = lanes[NX + u], lanes[NY + u], lanes[NZ + u], lanes[OVERLAP + u], lanes[PUSH + u], lanes[REFF + u]
            ax, ay, az, bx, by, bz = arms(u, nx, ny, nz, ra, ro, overlap, SURFACE_CONTACT, lanes)
        else:
            distance = sqrt(dx * dx + dy * dy + dz * dz)
            inverse = 1.0 / distance
            nx, ny, nz = dx * inverse, dy * inverse, dz * inverse
            overlap = reach - distance
            reff = ra * ro / reach
        if GUARD:
            least = ra if UNIFORM else min(ra, ro)
            if SHAPES:  # how far the bodies reach along n; an overlap by growth is in proportion to them anyhow
                if SHAPE_CONTACT[0] != BY_GROWTH and lanes[ROUND + u] == 0.0:
                    least = min(-(ax * nx + ay * ny + az * nz), bx * nx + by * ny + bz * nz) + 0.5 * overlap
            deep += np.uint64(overlap > DEEPEST * least)
        vx, vy, vz = lanes[VX + u], lanes[VY + u], lanes[VZ + u]
        vn = vx * nx + vy * ny + vz * nz
        tx = ty = tz = ux = uy = uz = inertia = 0.0
        if SHAPES:
            tx = vx + lanes[WAY + u] * az - lanes[WAZ + u] * ay - lanes[WOY + u] * bz + lanes[WOZ + u] * by
            ty = vy + lanes[WAZ + u] * ax - lanes[WAX + u] * az - lanes[WOZ + u] * bx + lanes[WOX + u] * bz
            tz = vz + lanes[WAX + u] * ay - lanes[WAY + u] * ax - lanes[WOX + u] * by + lanes[WOY + u] * bx
            vn = tx * nx + ty * ny + tz * nz
            tx, ty, tz = tx - vn * nx, ty - vn * ny, tz - vn * nz
        elif FRICTION:
            aa, ao = ra, ro
            if SURFACE_CONTACT:
                aa, ao = ra - 0.5 * overlap, ro - 0.5 * overlap
            wx = aa * lanes[WAX + u] + ao * lanes[WOX + u]
            wy = aa * lanes[WAY + u] + ao * lanes[WOY + u]
            wz = aa * lanes[WAZ + u] + ao * lanes[WOZ + u]
            tx = vx - vn * nx - (wy * nz - wz * ny)
            ty = vy - vn * ny - (wz * nx - wx * nz)
            tz = vz - vn * nz - (wx * ny - wy * nx)
        if ROLLING:
            inertia = rolling_inertia(equal[1], equal[0], equal[1], equal[0]) if UNIFORM else lanes[INERTIA + u]
            ux, uy, uz = lanes[WAX + u] - lanes[WOX + u], lanes[WAY + u] - lanes[WOY + u], lanes[WAZ + u] - lanes[WOZ + u]
        fn, damping, fx, fy, fz, qx, qy, qz, shift, loss = pair_contact(
            past, u, overlap, ra, 1.0 / ro, reff, meff, inertia, 1.0, push * vn, nx, ny, nz, tx, ty, tz, ux, uy, uz, dt, advance, push, coefficients, row,
        )
        if SHAPES:
            fn, damping = push * fn, push * damping
        lanes[PX + u], lanes[PY + u], lanes[PZ + u] = fn * nx + fx, fn * ny + fy, fn * nz + fz
        if TORQUES:
            gx = gy = gz = hx = hy = hz = 0.0
            if SHAPES:
                ax, ay, az, bx, by, bz = arms(u, nx, ny, nz, ra, ro, overlap, TORQUE_CONTACT, lanes)
                cx, cy, cz = lanes[PX + u], lanes[PY + u], lanes[PZ + u]
                gx, gy, gz = ay * cz - az * cy, az * cx - ax * cz, ax * cy - ay * cx
                hx, hy, hz = bz * cy - by * cz, bx * cz - bz * cx, by * cx - bx * cy
            elif FRICTION:
                aa, ao = ra, ro
                if TORQUE_CONTACT:
                    aa, ao = ra - 0.5 * overlap, ro - 0.5 * overlap
                cx, cy, cz = ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx
                gx, gy, gz, hx, hy, hz = -aa * cx, -aa * cy, -aa * cz, -ao * cx, -ao * cy, -ao * cz
            if ROLLING:
                share = pair_rolling_share(ra, ro)
                gx, gy, gz = gx + qx, gy + qy, gz + qz
                hx, hy, hz = hx - share * qx, hy - share * qy, hz - share * qz
            lanes[GX + u], lanes[GY + u], lanes[GZ + u] = gx, gy, gz
            if not SAME_TORQUE:
                lanes[HX + u], lanes[HY + u], lanes[HZ + u] = hx, hy, hz
        if SHIFTING or IMPLICIT or BUDGET:
            lanes[NX + u], lanes[NY + u], lanes[NZ + u] = nx, ny, nz
            lanes[SPRING + u], lanes[DAMPING + u], lanes[SHIFT + u], lanes[LOSS + u] = fn - damping, damping, shift, loss
        if BUDGET:
            lanes[FX + u], lanes[FY + u], lanes[FZ + u] = fx, fy, fz
            lanes[QX + u], lanes[QY + u], lanes[QZ + u] = qx, qy, qz
    return deep


@inlined
def deliver(u, b, p, equal, dt, advance, tally, lanes, past, who):
    """What lane u found: memory and books. Returns who feels it, the other, and whether both do."""
    a, o, both, k = np.uint64(who[FELT + u]), np.uint64(who[OTHER + u]), who[BOTH + u] != 0, np.uint64(who[ENTRY + u])
    for c in range(BASE):
        p.memory[k, c] = past[np.uint64(c * BLOCK) + u]
    nx, ny, nz = lanes[NX + u], lanes[NY + u], lanes[NZ + u]
    if SHIFTING:
        ma, mo = (equal[1], equal[1]) if UNIFORM else (b.mass[a], b.mass[o])
        meff = lanes[MEFF + u] if FROZEN or not UNIFORM else ma * mo / (ma + mo)
        if b.moving[a] and not b.frozen[a]:
            aside(b, a, lanes[SHIFT + u] * meff / ma, nx, ny, nz)
        if both and b.moving[o] and not b.frozen[o]:
            aside(b, o, -lanes[SHIFT + u] * meff / mo, nx, ny, nz)
        if advance:
            tally[0] -= lanes[LOSS + u] if both else 0.5 * lanes[LOSS + u]
    if IMPLICIT:
        aside(b, a, lanes[SPRING + u], nx, ny, nz)
        if both:
            aside(b, o, -lanes[SPRING + u], nx, ny, nz)
    if VIRIAL:
        virial = lanes[DX + u] * lanes[PX + u] + lanes[DY + u] * lanes[PY + u] + lanes[DZ + u] * lanes[PZ + u]
        tally[3] += virial if both else 0.5 * virial
    if BUDGET:
        keep_books(u, k, a, o, both, nx, ny, nz, b, p, dt, advance, tally, lanes)
    return a, o, both


@inlined
def aside(b, i, size, nx, ny, nz):
    """Sets `size` n aside for particle i."""
    b.aside[i, 0] += size * nx
    b.aside[i, 1] += size * ny
    b.aside[i, 2] += size * nz


@inlined
def give(b, a, u, near, lanes):
    """Adds what lane u found to the force and torque of who feels it."""
    if FREE:
        near.pushed[a >> np.uint64(3)] = 1
    b.force[a, 0] += lanes[PX + u]
    b.force[a, 1] += lanes[PY + u]
    b.force[a, 2] += lanes[PZ + u]
    if TORQUES:
        b.torque[a, 0] += lanes[GX + u]
        b.torque[a, 1] += lanes[GY + u]
        b.torque[a, 2] += lanes[GZ + u]


@inlined
def give_other(b, o, u, near, lanes):
    """The same for the other."""
    if FREE:
        near.pushed[o >> np.uint64(3)] = 1
    b.force[o, 0] -= lanes[PX + u]
    b.force[o, 1] -= lanes[PY + u]
    b.force[o, 2] -= lanes[PZ + u]
    if TORQUES:
        b.torque[o, 0] += lanes[TORQUE[0] + u]
        b.torque[o, 1] += lanes[TORQUE[1] + u]
        b.torque[o, 2] += lanes[TORQUE[2] + u]


@compiled
def wall_parting(i, base, wvx, wvy, wvz, turning, b, memory, dt, advance, tally):
    """A wall forgets a particle as soon as they part."""
    if BUDGET:
        if advance:
            drive(memory, i, base, REST, wvx, wvy, wvz, turning, 0.5 * dt, tally)
        settle(memory, i, base, b.v[i, 0] - wvx, b.v[i, 1] - wvy, b.v[i, 2] - wvz, b.omega[i], turning, 0.5 * dt, advance, tally)
    for c in range(base):
        memory[i, c] = 0.0


@compiled
def add(i, c, f, b, memory, dt, advance, tally):
    """Adds f to component c of the force on particle i; `memory` holds the last one for the work."""
    b.force[i, c] += f
    if BUDGET:
        if advance and b.moving[i]:
            tally[5] += 0.5 * dt * (memory[i, c] + f) * b.v[i, c]
        memory[i, c] = f


@compiled
def drag(i, gamma, b, memory, dt, advance, tally):
    """Viscous drag -gamma v on particle i; `memory` holds its last force for the work."""
    for c in range(3):
        f = -gamma * b.v[i, c]
        b.force[i, c] += f
        if BUDGET:
            if advance:
                tally[2] += 0.5 * dt * (memory[i, c] + f) * b.v[i, c]
            memory[i, c] = f
