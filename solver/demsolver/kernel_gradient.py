"""The step of scenes whose normal laws have `solve` (discrete gradient): in the place of kernel.run_steps, behind the same header.

    v += dt/2m F;  omega += dt/2I T          F, T: all that is not a normal spring or gravity
    u = dt (v + v')/2;  v' = v + dt/m (springs and gravity, mean over the step);  x += u
    F, T = forces(x, u/dt, omega);  v = v' + dt/2m F;  omega += dt/2I T

The mean force of a contact acts along (r + r')/(|r| + |r'|), r, r' being the vector between the centres before and after: then its work is
exactly the loss of the spring's energy, and linear and angular momentum stay. Contacts are solved one by one, each in closed form, in sweeps over
all of them until nothing changes. A scene of springs and gravity alone keeps its energy to rounding at any step.

The pairs of a step are those of the list; it must hold at both ends of the step, so it is renewed before a step that would leave half the skin.
"""

# ruff: noqa: F821
from math import sqrt

import numpy as np

SWEEPS = 2000
AGREED = 1e-15  # change of a contact's part of the way in one sweep, relative to that part and to the overlap: rounding


@compiled
def pair_sweep(b, p, shifts, coefficients, ntypes, dt, inverse_mass, path, pull, margin):
    """Solves every pair once, given all others; returns the largest relative change. pull: (m, 3) mean force of each pair on its row's particle."""
    largest = 0.0
    for i in range(b.x.shape[0]):
        for k in range(p.first[i], p.first[i + 1]):
            j = np.int64(p.partner[k])
            if PERIODIC:
                t = np.int64(p.code[k])
                if t >= PARTNER_FEELS or (i == j and t > HOME):
                    continue  # the other half of a pair across a face: solved once
            dx, dy, dz = b.x[i, 0] - b.x[j, 0], b.x[i, 1] - b.x[j, 1], b.x[i, 2] - b.x[j, 2]
            if PERIODIC:
                dx, dy, dz = dx - shifts[t, 0], dy - shifts[t, 1], dz - shifts[t, 2]
            reach = b.radius[i] + b.radius[j]
            before = sqrt(dx * dx + dy * dy + dz * dz)
            if before > reach + margin:
                continue
            gx, gy, gz = path[i, 0] - path[j, 0], path[i, 1] - path[j, 1], path[i, 2] - path[j, 2]
            after = sqrt((dx + gx) ** 2 + (dy + gy) ** 2 + (dz + gz) ** 2)
            both = before + after
            nx, ny, nz = (2.0 * dx + gx) / both, (2.0 * dy + gy) / both, (2.0 * dz + gz) / both
            gain = 0.5 * dt * dt * (inverse_mass[i] + inverse_mass[j])
            approach = -(nx * (gx - gain * pull[k, 0]) + ny * (gy - gain * pull[k, 1]) + nz * (gz - gain * pull[k, 2]))
            row = 0 if ONE_LAW else b.kind[i] * ntypes + b.kind[j]
            mean = pair_solve(reach - before, approach, gain * (nx * nx + ny * ny + nz * nz), coefficients, row)
            cx, cy, cz = mean * nx - pull[k, 0], mean * ny - pull[k, 1], mean * nz - pull[k, 2]
            if cx != 0.0 or cy != 0.0 or cz != 0.0:
                size = abs(approach) + abs(reach - before) + gain * abs(mean)
                largest = max(largest, gain * sqrt(cx * cx + cy * cy + cz * cz) / size)
                pull[k, 0], pull[k, 1], pull[k, 2] = mean * nx, mean * ny, mean * nz
                a, c = 0.5 * dt * dt * inverse_mass[i], 0.5 * dt * dt * inverse_mass[j]
                path[i, 0] += a * cx
                path[i, 1] += a * cy
                path[i, 2] += a * cz
                path[j, 0] -= c * cx
                path[j, 1] -= c * cy
                path[j, 2] -= c * cz
    return largest


@compiled
def wall_solved(i, nx, ny, nz, overlap, approach, gain, mean, inverse_mass, dt, path, pull):
    """Gives particle i the mean force of a wall in the place of the one it had; returns the relative change."""
    cx, cy, cz = mean * nx - pull[i, 0], mean * ny - pull[i, 1], mean * nz - pull[i, 2]
    if cx == 0.0 and cy == 0.0 and cz == 0.0:
        return 0.0
    pull[i, 0], pull[i, 1], pull[i, 2] = mean * nx, mean * ny, mean * nz
    a = 0.5 * dt * dt * inverse_mass[i]
    path[i, 0] += a * cx
    path[i, 1] += a * cy
    path[i, 2] += a * cz
    return gain * sqrt(cx * cx + cy * cy + cz * cz) / (abs(approach) + abs(overlap) + gain * abs(mean))


@compiled
def solve_step(b, p, shifts, coefficients, ntypes, walls, dt, inverse_mass, path, pull, wall_pull):
    """Finds the way (n, 3) of every particle in this step; returns whether the sweeps agreed."""
    n = b.x.shape[0]
    farthest = 0.0
    for i in range(n):
        straight = 0.0
        for c in range(3):
            path[i, c] = (dt if b.moving[i] else 0.0) * b.v[i, c] + 0.5 * dt * dt * inverse_mass[i] * b.aside[i, c]
            straight += path[i, c] ** 2
        farthest = max(farthest, straight)
    margin = 4.0 * sqrt(farthest)
    pull[:] = 0.0
    wall_pull[:] = 0.0
    last = np.inf
    for _ in range(SWEEPS):
        change = wall_sweep(b, walls, dt, inverse_mass, path, wall_pull, margin)
        if PAIRS:
            change = max(change, pair_sweep(b, p, shifts, coefficients, ntypes, dt, inverse_mass, path, pull, margin))
        if change <= AGREED or (change < 1e-13 and change >= last):
            farthest = 0.0
            for i in range(n):
                farthest = max(farthest, path[i, 0] ** 2 + path[i, 1] ** 2 + path[i, 2] ** 2)
            if 4.0 * farthest <= margin * margin:
                return True
            margin = 4.0 * sqrt(farthest)  # springs threw something farther than it flew: look at more pairs
            change = np.inf
        last = change
    return False


@compiled
def forces(b, flat, movers, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, advance, tallies, paces):
    """Forces and torques at the present positions; what the step solves anew also in b.aside."""
    clear(NONE, b.x.shape[0], b)
    if PAIRS:
        list_near(b, movers, p, near, shifts, equal, 0.0, 0.0)
    sweep(FORCES, b, flat, movers, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, advance, tallies, paces)


@compiled
def kick_all(b, movers):
    """Half a step of all that is not solved anew."""
    for i in range(movers):
        m = 0 if UNIFORM else i
        for c in range(3):
            b.v[i, c] += b.kick[m, c] * (b.force[i, c] - b.aside[i, c])
            if ROTATES:
                b.omega[i, c] += b.spin[m, c] * b.torque[i, c]


@entry
def run_steps(
    start, steps, age, rhythm, b, flat, free, movers, clumps, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, tallies, paces, guard
):
    """As kernel.run_steps. Instead of the steps done -1: a step leaves the list even though that is new; -2: the sweeps did not agree."""
    reach = rhythm[3]
    n = b.x.shape[0]
    done = 0
    path, mean = np.zeros((n, 3)), np.zeros((n, 3))
    pull, wall_pull = np.zeros((len(p.partner), 3)), np.zeros((len(walls) // 5, n, 3))
    inverse_mass = np.zeros(n)
    for i in range(n):
        inverse_mass[i] = 0.0 if b.frozen[i] or i >= movers else 2.0 * b.kick[0 if UNIFORM else i, 0] / dt
    if start == 2:
        forces(b, flat, movers, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, False, tallies, paces)
        return done, age, 0
    while True:
        if start == 0:
            if done == steps:
                return done, age, 0
            kick_all(b, movers)
        start = 0
        steady_forces(b, fields)
        if not solve_step(b, p, shifts, coefficients, ntypes, walls, dt, inverse_mass, path, pull, wall_pull):
            return -2, age, 0
        farthest = 0.0
        for i in range(n):
            moved = 0.0
            for c in range(3):
                moved += (b.x[i, c] + path[i, c] - b.held[i, c]) ** 2
            farthest = max(farthest, moved)
        if farthest > reach:
            return (-1 if age == 0 else done), age, DUE
        age += 1
        for i in range(n):
            for c in range(3):
                b.x[i, c] += path[i, c]
                mean[i, c] = path[i, c] / dt
                if inverse_mass[i] > 0.0:
                    path[i, c] = 2.0 * (path[i, c] / dt - b.v[i, c]) + b.v[i, c]
                else:
                    path[i, c] = b.v[i, c]
                b.v[i, c] = mean[i, c]
        if MOVING:
            move_walls(walls, dt)
        forces(b, flat, movers, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, True, tallies, paces)
        for i in range(n):
            for c in range(3):
                b.v[i, c] = path[i, c]
        kick_all(b, movers)
        done += 1
