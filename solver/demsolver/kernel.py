"""The step loop: the template from which `demsolver.specialise` makes one compiled loop for one scene.

This file is read as text and placed behind a generated header, which binds, as globals of the new module:

    compiled, threaded, entry  the compiler; the same with parallel loops when the scene runs on several threads; for what Python calls
    pair_contact, pair_stored, pair_reach  force and stored energy of the scene's pair law, put together from demsolver/contact; how far beyond
                               touching a contact goes on
    wall_forces, wall_stored   all walls of the scene, one after another
    move_walls                 carries moving planes on by a step
    field_forces               gravity, freeze, ... of the scene in their order
    PAIRS, FRICTION, ROLLING, BEYOND, OUTLIVES, BUDGET, PERIODIC, FROZEN, VIRIAL, THREADED, SURFACE_CONTACT, TORQUE_CONTACT, SHIFTING, IMPLICIT,
    MOVING, VERLET: constants; what is False costs nothing. BASE: columns of memory that the pair law has. ROLLING_INERTIA: of one sphere rolling
                               about its contact point, over m R^2

Velocity Verlet as LAMMPS does it: contact forces of step n see x(n) and the velocities of step n - 1/2 (at set-up: of step n).

    v += dt/2m F;  omega += dt/2I T;  x += dt v;  F, T = forces(x, v, omega);  v += dt/2m F;  omega += dt/2I T

Semi-implicit Euler (not VERLET) is the same with one whole kick; its velocities of step n are those that brought x(n) about.

    v += dt/m F;  omega += dt/I T;  x += dt v;  F, T = forces(x, v, omega)

A pair across a periodic face is listed twice, once for each particle, with the image of the other: the engines compute it so (newton off),
and only then are forces the same to rounding. Bits of touching: 1 in contact at the last step; 2 (OUTLIVES) since the list was built.

Memory columns of a contact: first BASE columns of the law's own; with BUDGET also what took energy in the last step: three columns each of the
normal damping force, the tangential force, its torques on both sides, the rolling torques on both sides; then the power that a wall's motion gives
to the spring.
Tally: 0 work of the normal damping, 1 work of the tangential force, 2 work of viscous drag, 4 work of the rolling torques; negative while they
take energy; 5 work of the walls' motion on the particles. With VIRIAL: 3 the sum of r.F over the pairs of the last force evaluation.
"""

# ruff: noqa: F821
from math import sqrt

import numpy as np
from numba import prange

REST = (0.0,) * 19  # `now` of a contact that has ended


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
    for c in range(19):
        memory[k, base + c] = now[c]


@compiled
def settle(memory, k, base, vx, vy, vz, wi, wj, half_dt, advance, tally):
    """The last work on a contact that has ended."""
    if advance:
        spend(memory, k, base, REST, vx, vy, vz, wi, wj, half_dt, tally)
    remember(memory, k, base, REST)


@compiled
def pair_forces(start, stop, b, p, shifts, coefficients, ntypes, dt, advance, force, torque, tally):
    """Contact forces of the particles start..stop with the partners of their rows, added to force and torque of both."""
    x, v, w, radius, mass = b.x, b.v, b.omega, b.radius, b.mass
    for i in range(start, stop):
        xi, yi, zi = x[i, 0], x[i, 1], x[i, 2]
        ri = radius[i]
        for k in range(p.first[i], p.first[i + 1]):
            j = p.partner[k]
            half_dt, both = 0.5 * dt, True
            if PERIODIC:
                s = p.shift[k]
                if s != HOME:  # half a pair: the other half stands in the row of j, as seen from there
                    half_dt, both = 0.25 * dt, False
                dx = xi - (x[j, 0] + shifts[s, 0])
                dy = yi - (x[j, 1] + shifts[s, 1])
                dz = zi - (x[j, 2] + shifts[s, 2])
            else:
                dx, dy, dz = xi - x[j, 0], yi - x[j, 1], zi - x[j, 2]
            rj = radius[j]
            square = dx * dx + dy * dy + dz * dz
            reach = ri + rj
            row = b.kind[i] * ntypes + b.kind[j]
            beyond = reach
            if BEYOND and p.touching[k] & 1:
                beyond += pair_reach(ri * rj / reach, coefficients, row)
            if square >= beyond * beyond:
                if p.touching[k] & 1:
                    if BUDGET and BEYOND and advance:  # what a contact holds where it snaps off
                        held = pair_stored(p.memory, k, reach - beyond, ri, 1.0 / rj, ri * rj / reach, 0.0, 0.0, dt, coefficients, row)
                        tally[0] -= held[0] if both else 0.5 * held[0]
                    if BUDGET:
                        settle(p.memory, k, BASE, v[i, 0] - v[j, 0], v[i, 1] - v[j, 1], v[i, 2] - v[j, 2], w[i], w[j], half_dt, advance, tally)
                    if not OUTLIVES:
                        for c in range(BASE):
                            p.memory[k, c] = 0.0
                    p.touching[k] = 2 if OUTLIVES else 0
                continue
            p.touching[k] = 3 if OUTLIVES else 1
            distance = sqrt(square)
            nx, ny, nz = dx / distance, dy / distance, dz / distance
            overlap = reach - distance
            vx, vy, vz = v[i, 0] - v[j, 0], v[i, 1] - v[j, 1], v[i, 2] - v[j, 2]
            vn = vx * nx + vy * ny + vz * nz
            meff = mass[i] * mass[j] / (mass[i] + mass[j])
            if FROZEN:
                if b.frozen[i]:
                    meff = mass[j]
                elif b.frozen[j]:
                    meff = mass[i]
            ai, aj = ri, rj
            if SURFACE_CONTACT:
                ai, aj = ri - 0.5 * overlap, rj - 0.5 * overlap
            wx = ai * w[i, 0] + aj * w[j, 0]
            wy = ai * w[i, 1] + aj * w[j, 1]
            wz = ai * w[i, 2] + aj * w[j, 2]
            tx = vx - vn * nx - (wy * nz - wz * ny)
            ty = vy - vn * ny - (wz * nx - wx * nz)
            tz = vz - vn * nz - (wx * ny - wy * nx)
            inertia = 0.0
            ux = uy = uz = 0.0
            if ROLLING:
                inertia = ROLLING_INERTIA / (1.0 / (mass[i] * ri * ri) + 1.0 / (mass[j] * rj * rj))
                ux, uy, uz = w[i, 0] - w[j, 0], w[i, 1] - w[j, 1], w[i, 2] - w[j, 2]
            fn, damping, fx, fy, fz, qx, qy, qz, shift, loss = pair_contact(
                p.memory, k, overlap, ri, 1.0 / rj, ri * rj / reach, meff, inertia, 1.0, vn, nx, ny, nz, tx, ty, tz, ux, uy, uz, dt, advance,
                coefficients, row,
            )
            if SHIFTING:
                if b.drift[i] > 0.0 and not b.frozen[i]:
                    give = shift * meff / mass[i]
                    b.aside[i, 0] += give * nx
                    b.aside[i, 1] += give * ny
                    b.aside[i, 2] += give * nz
                if both and b.drift[j] > 0.0 and not b.frozen[j]:
                    give = shift * meff / mass[j]
                    b.aside[j, 0] -= give * nx
                    b.aside[j, 1] -= give * ny
                    b.aside[j, 2] -= give * nz
                if advance:
                    tally[0] -= loss if both else 0.5 * loss
            force[i, 0] += fn * nx + fx
            force[i, 1] += fn * ny + fy
            force[i, 2] += fn * nz + fz
            if both:
                force[j, 0] -= fn * nx + fx
                force[j, 1] -= fn * ny + fy
                force[j, 2] -= fn * nz + fz
            if IMPLICIT:
                spring = fn - damping
                b.aside[i, 0] += spring * nx
                b.aside[i, 1] += spring * ny
                b.aside[i, 2] += spring * nz
                if both:
                    b.aside[j, 0] -= spring * nx
                    b.aside[j, 1] -= spring * ny
                    b.aside[j, 2] -= spring * nz
            if VIRIAL:
                virial = dx * (fn * nx + fx) + dy * (fn * ny + fy) + dz * (fn * nz + fz)
                tally[3] += virial if both else 0.5 * virial
            if FRICTION:
                if TORQUE_CONTACT:
                    ai, aj = ri - 0.5 * overlap, rj - 0.5 * overlap
                else:
                    ai, aj = ri, rj
                cx, cy, cz = ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx
                torque[i, 0] -= ai * cx
                torque[i, 1] -= ai * cy
                torque[i, 2] -= ai * cz
                if both:
                    torque[j, 0] -= aj * cx
                    torque[j, 1] -= aj * cy
                    torque[j, 2] -= aj * cz
            share_j = 1.0
            if ROLLING:
                share_j = pair_rolling_share(ri, rj)
                torque[i, 0] += qx
                torque[i, 1] += qy
                torque[i, 2] += qz
                if both:
                    torque[j, 0] -= share_j * qx
                    torque[j, 1] -= share_j * qy
                    torque[j, 2] -= share_j * qz
            if BUDGET:
                now = (
                    damping * nx, damping * ny, damping * nz, fx, fy, fz,
                    -ai * (ny * fz - nz * fy), -ai * (nz * fx - nx * fz), -ai * (nx * fy - ny * fx),
                    -aj * (ny * fz - nz * fy), -aj * (nz * fx - nx * fz), -aj * (nx * fy - ny * fx),
                    qx, qy, qz, -share_j * qx, -share_j * qy, -share_j * qz, 0.0,
                )
                if advance:
                    spend(p.memory, k, BASE, now, vx, vy, vz, w[i], w[j], half_dt, tally)
                remember(p.memory, k, BASE, now)


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
def drag(i, gamma, b, memory, dt, advance, tally):
    """Viscous drag -gamma v on particle i; `memory` holds its last force for the work."""
    for c in range(3):
        f = -gamma * b.v[i, c]
        b.force[i, c] += f
        if BUDGET:
            if advance:
                tally[2] += 0.5 * dt * (memory[i, c] + f) * b.v[i, c]
            memory[i, c] = f


@compiled
def share(first, n, t, threads):
    """First row of thread t: every thread gets rows with about as many pairs. t = threads: n."""
    wanted = first[n] * np.int64(t) // threads
    low, high = 0, n
    while low < high:
        middle = (low + high) // 2
        if first[middle + 1] <= wanted:
            low = middle + 1
        else:
            high = middle
    return n if np.int64(t) == threads else low


@threaded
def shared_pair_forces(b, p, shifts, coefficients, ntypes, dt, advance, force, torque, parts, tallies):
    """pair_forces on several threads: each sums into its own part, then the parts are summed in a fixed order."""
    threads, n = parts.shape[0], force.shape[0]
    for t in prange(threads):
        parts[t] = 0.0
        start, stop = share(p.first, n, t, threads), share(p.first, n, t + 1, threads)
        pair_forces(start, stop, b, p, shifts, coefficients, ntypes, dt, advance, parts[t, 0], parts[t, 1], tallies[t])
    for i in prange(n):
        for t in range(threads):
            for c in range(3):
                force[i, c] += parts[t, 0, i, c]
                torque[i, c] += parts[t, 1, i, c]


@compiled
def forces(b, p, shifts, coefficients, ntypes, walls, fields, dt, advance, parts, tallies):
    """Force and torque of every particle, written to b.force and b.torque.

    parts: (t, 2, n, 3) scratch of t threads. tallies: (t, 6).
    """
    b.force[:] = 0.0
    b.torque[:] = 0.0
    if SHIFTING or IMPLICIT:
        b.aside[:] = 0.0
    if VIRIAL:
        tallies[:, 3] = 0.0
    if PAIRS:
        if THREADED:
            shared_pair_forces(b, p, shifts, coefficients, ntypes, dt, advance, b.force, b.torque, parts, tallies)
        else:
            pair_forces(0, b.x.shape[0], b, p, shifts, coefficients, ntypes, dt, advance, b.force, b.torque, tallies[0])
    wall_forces(b, walls, dt, advance, tallies[0])
    field_forces(b, fields, dt, advance, tallies[0])


@compiled
def kick(b):
    """A step (Verlet: half of it) of acceleration; what is set aside in implicit scenes is not part of it."""
    for i in range(b.x.shape[0]):
        for c in range(3):
            b.v[i, c] += b.kick[i] * (b.force[i, c] - b.aside[i, c] if IMPLICIT else b.force[i, c])
            b.omega[i, c] += b.spin[i] * b.torque[i, c]


@compiled
def kick_drift(b):
    """A kick and a step of motion; the largest squared way since the list was built."""
    farthest = 0.0
    for i in range(b.x.shape[0]):
        way = 0.0
        for c in range(3):
            b.v[i, c] += b.kick[i] * b.force[i, c]
            b.omega[i, c] += b.spin[i] * b.torque[i, c]
            b.x[i, c] += b.drift[i] * b.v[i, c]
            if SHIFTING:
                b.x[i, c] += b.aside[i, c]
            way += (b.x[i, c] - b.held[i, c]) ** 2
        farthest = max(farthest, way)
    return farthest


@entry
def run_steps(start, steps, age, rhythm, b, p, shifts, coefficients, ntypes, walls, fields, dt, parts, tallies):
    """Runs until `steps` are done or the list is due; returns (steps done, age of the list, list due in mid-step?).

    start: 0 at the begin of a step; 1 in mid-step, behind the renewal of the list; 2 set-up: forces only, histories stay.
    rhythm: (every, delay, check, squared half skin) as LAMMPS' neigh_modify.
    """
    every, delay, check, reach = rhythm
    done = 0
    while True:
        if start == 0:
            if done == steps:
                return done, age, False
            farthest = kick_drift(b)
            if MOVING:
                move_walls(walls, dt)
            age += 1
            if age >= delay and age % every == 0 and (not check or farthest > reach):
                return done, age, True
        forces(b, p, shifts, coefficients, ntypes, walls, fields, dt, start != 2, parts, tallies)
        if start == 2:
            return done, age, False
        if VERLET:
            kick(b)
        done += 1
        start = 0


@entry
def stored(b, p, shifts, coefficients, ntypes, walls, dt):
    """Elastic energy in all contacts: (normal, tangential, rolling), at the current positions and histories."""
    normal = tangential = rolling = 0.0
    if PAIRS:
        for i in range(b.x.shape[0]):
            for k in range(p.first[i], p.first[i + 1]):
                j = p.partner[k]
                square = vn = 0.0
                for c in range(3):
                    d = b.x[i, c] - b.x[j, c]
                    if PERIODIC:
                        d -= shifts[p.shift[k], c]
                    square += d * d
                    vn += d * (b.v[i, c] - b.v[j, c])
                reach = b.radius[i] + b.radius[j]
                if square < reach * reach or (BEYOND and p.touching[k] & 1):
                    distance = sqrt(square)
                    meff = b.mass[i] * b.mass[j] / (b.mass[i] + b.mass[j])
                    if FROZEN:
                        if b.frozen[i]:
                            meff = b.mass[j]
                        elif b.frozen[j]:
                            meff = b.mass[i]
                    row = b.kind[i] * ntypes + b.kind[j]
                    en, et, er = pair_stored(
                        p.memory, k, reach - distance, b.radius[i], 1.0 / b.radius[j], b.radius[i] * b.radius[j] / reach, meff, vn / distance, dt,
                        coefficients, row,
                    )
                    part = 0.5 if PERIODIC and p.shift[k] != HOME else 1.0
                    normal += part * en
                    tangential += part * et
                    rolling += part * er
    en, et, er = wall_stored(b, walls, dt)
    return normal + en, tangential + et, rolling + er
