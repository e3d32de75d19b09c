"""The step loop: the template from which `demsolver.specialise` makes one compiled loop for one scene.

This file is read as text and placed behind a generated header, which binds, as globals of the new module:

    compiled, inlined, threaded, entry  the compiler: a function; one that is written out where it is called; one with parallel loops when the scene
                               runs on several threads; one that Python calls
    pair_contact, pair_stored, pair_reach  force and stored energy of the scene's pair law, put together from demsolver/contact; how far beyond
                               touching a contact goes on
    wall_forces, wall_stored   all walls of the scene, one after another, on one particle
    move_walls                 carries moving planes on by a step
    field_forces               gravity, freeze, ... of the scene in their order, on one particle
    PAIRS, FRICTION, ROLLING, ROTATES, BEYOND, OUTLIVES, BUDGET, PERIODIC, FROZEN, VIRIAL, THREADED, SURFACE_CONTACT, TORQUE_CONTACT, SHIFTING,
    IMPLICIT, MOVING, VERLET, SLEEPS, FREE, UNIFORM, ONE_LAW, GUARD, SHAPES, CLUMPS, TORQUES: constants; what is False (UNIFORM, ONE_LAW and FREE: True) costs
                               nothing. BASE: columns of memory that the pair law has. ROLLING_INERTIA: of one sphere rolling about its
                               contact point, over m R^2
    turn, move_clumps          superquadrics turn (kernel_turn.py); clumps move (kernel_clumps.py)

Velocity Verlet as LAMMPS does it: contact forces of step n see x(n) and the velocities of step n - 1/2 (at set-up: of step n).

    v += dt/2m F;  omega += dt/2I T;  x += dt v;  F, T = forces(x, v, omega);  v += dt/2m F;  omega += dt/2I T

Semi-implicit Euler (not VERLET) is the same with one whole kick; its velocities of step n are those that brought x(n) about.

    v += dt/m F;  omega += dt/I T;  x += dt v;  F, T = forces(x, v, omega)

The rows are cut into chunks, of a fixed number of rows whatever the number of threads. A sweep first does the pairs between chunks, then, chunk by chunk, the
pairs within, walls and fields: behind them nobody asks for these particles any more, so they are kicked, kicked and moved on to the next step while they are
still at hand. Threads share the chunks out, and every sum is made in one order: results are the same bits for any number of threads.

A pair across a periodic face is listed twice, once for each particle, with the image of the other: the engines compute it so (newton off),
and only then are forces the same to rounding. Bits of touching: 1 in contact at the last step; 2 (OUTLIVES) since the list was built.

Near list: of the listed pairs those that can touch within the next few steps, which is a bound, not a guess (see kernel_near.py).
"""

# ruff: noqa: F821
from math import sqrt

import numpy as np
from numba import prange

from demsolver.state import Bodies, Clumped, Shaped

FORCES, FINISH, GO_ON = 0, 1, 2  # modes of a sweep
DUE, TOO_FAST, TOO_DEEP = 1, 2, 3  # why run_steps returns before its steps are done
NONE, NOBODY = np.int64(0), np.uint64(0)


@compiled
def contacts(c, low, high, mine, b, p, near, shifts, equal, coefficients, ntypes, dt, advance, tally, lanes, past, who):
    """Contacts of the near entries low..high of chunk c. What they do to particles in the rows below `mine` is given to them at once, the rest, with
    which other threads may be busy, is kept until `give_kept`."""
    w = near.chunks[c, KEPT_FIRST]
    u = NOBODY
    for q in range(np.uint64(low), np.uint64(high)):
        u += look(q, u, b, p, near, shifts, equal, coefficients, ntypes, dt, advance, tally, lanes, who)
        if u == BLOCK:
            w = do_block(u, w, mine, b, p, near, equal, coefficients, ntypes, dt, advance, tally, lanes, past, who)
            u = NOBODY
    w = do_block(u, w, mine, b, p, near, equal, coefficients, ntypes, dt, advance, tally, lanes, past, who)
    if THREADED and mine < b.x.shape[0]:
        near.chunks[c, KEPT_END] = w


@compiled
def do_block(count, w, mine, b, p, near, equal, coefficients, ntypes, dt, advance, tally, lanes, past, who):
    """The contacts in the lanes 0..count; w: where what is kept goes, returned as it then is."""
    for u in range(count):
        gather(u, b, p, equal, ntypes, lanes, past, who)
    deep = act(count, equal, coefficients, dt, advance, lanes, past, who)
    if GUARD:
        tally[6] += deep
    for u in range(count):
        a, o, both = deliver(u, b, p, equal, dt, advance, tally, lanes, past, who)
        if THREADED and np.int64(a) >= mine:
            w = keep(w, a, 1.0, (GX, GY, GZ), near, u, lanes)
        else:
            give(b, a, u, near, lanes)
        if both:
            if THREADED and np.int64(o) >= mine:
                w = keep(w, o, -1.0, TORQUE, near, u, lanes)
            else:
                give_other(b, o, u, near, lanes)
    return w


@inlined
def keep(w, i, sign, turn, near, u, lanes):
    """Keeps for particle i in place w what lane u found, its force times `sign` and the torque of the fields `turn`; returns the next place."""
    near.kept_row[w] = i
    kept = near.kept_action[w]
    kept[0], kept[1], kept[2] = sign * lanes[PX + u], sign * lanes[PY + u], sign * lanes[PZ + u]
    if TORQUES:
        kept[3], kept[4], kept[5] = lanes[turn[0] + u], lanes[turn[1] + u], lanes[turn[2] + u]
    return w + 1


@compiled
def give_kept(low, high, b, near):
    """Gives the particles low..high what was kept for them, in the order in which `contacts` of one thread gives it."""
    for c in range(near.chunks.shape[0] - 1, -1, -1):
        for u in range(near.chunks[c, KEPT_FIRST], near.chunks[c, KEPT_END]):
            i, kept = near.kept_row[u], near.kept_action[u]
            if low <= i < high:
                if FREE:
                    near.pushed[i >> 3] = 1
                for d in range(3):
                    b.force[i, d] += kept[d]
                    if TORQUES:
                        b.torque[i, d] += kept[3 + d]


@compiled
def end_step(c, mode, b, flat, movers, pushed, walls, fields, dt, advance, tally):
    """What chunk c still has to do behind its contacts: walls, fields and, by `mode`, motion: no more than FORCES; FINISH the step; GO_ON to the next
    positions. Returns the largest squared change of a velocity on the way there.
    """
    low, high = c * CHUNK, min(b.x.shape[0], (c + 1) * CHUNK)
    jump = 0.0
    if FREE:  # who touches nothing flies on: only the eights of rows that were pushed are looked at
        for k in range(low >> 3, (high + 7) >> 3):
            if pushed[k] != 0:
                jump = max(jump, push(8 * k, min(high, 8 * k + 8), mode, b, flat, movers, dt))
                if mode == GO_ON:
                    clear(8 * k, min(high, 8 * k + 8), b)
                    pushed[k] = 0
    else:
        for i in range(low, high):
            wall_forces(i, b, walls, dt, advance, tally)
            field_forces(i, b, fields, dt, advance, tally)
        jump = push(low, high, mode, b, flat, movers, dt)
    if mode == GO_ON:
        drift(low, min(high, movers), flat, dt)
        if not FREE:
            clear(low, min(high, movers) if CLUMPS else high, b)  # what acts on the members is still to be gathered
    return 4.0 * jump if VERLET else jump


@inlined
def push(low, high, mode, b, flat, movers, dt):
    """What forces do to the particles low..high at the end of a step. Returns the largest squared change of a velocity by a kick."""
    jump = 0.0
    if PAIRS or GUARD:  # nobody else asks
        for i in range(low, high):
            k = b.kick[0 if UNIFORM else i, 0]
            jump = max(jump, k * k * (b.force[i, 0] ** 2 + b.force[i, 1] ** 2 + b.force[i, 2] ** 2))
    last = min(high, movers)
    if mode == GO_ON:
        kick(low, last, 1.0 if VERLET else 0.0, flat)
        if SHAPES:
            turn(low, last, TURN_BOTH, b, dt)
    elif mode == FINISH and VERLET:
        kick(low, last, 0.0, flat)
        if SHAPES:
            turn(low, last, TURN_SECOND, b, dt)
    return jump


if SHAPES:

    @compiled
    def shapes_of(b):
        return b.shaped.quat, b.shaped.angmom, b.shaped.inertia, b.shaped.axes, b.shaped.blockiness, b.shaped.size

    @compiled
    def shaped_again(s):
        return Shaped(s[0], s[1], s[2], s[3], s[4], s[5])

else:

    @compiled
    def shapes_of(b):
        return (b.x,)

    @compiled
    def shaped_again(s):
        return ()


if CLUMPS:

    @compiled
    def clumps_of(b):
        return b.clumped.clump, b.clumped.heft

    @compiled
    def clumped_again(c):
        return Clumped(c[0], c[1])

else:

    @compiled
    def clumps_of(b):
        return (b.x,)

    @compiled
    def clumped_again(c):
        return ()


@compiled
def plain_of(b):
    """The arrays of the bodies but those of shapes and clumps: Numba hands no tuple within a tuple to the threads."""
    return b.x, b.v, b.omega, b.force, b.torque, b.radius, b.mass, b.kind, b.mask, b.frozen, b.kick, b.spin, b.moving, b.held, b.aside


@compiled
def bodies_again(t, s, c):
    """The bodies of these arrays, of shapes_of and of clumps_of."""
    return Bodies(
        t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[8], t[9], t[10], t[11], t[12], t[13], t[14], shaped_again(s), clumped_again(c)
    )


@compiled
def cross_share(t, plain, shapes, grouped, p, near, shifts, equal, coefficients, ntypes, dt, advance, tallies):
    """Thread t's pairs between chunks."""
    b = bodies_again(plain, shapes, grouped)
    for c in range(near.cross_share[t + 1] - 1, near.cross_share[t] - 1, -1):
        contacts(
            c, near.chunks[c, CROSS_FIRST], near.chunks[c, CROSS_END], near.cross_share[t + 1] * CHUNK, b, p, near, shifts, equal, coefficients,
            ntypes, dt, advance, tallies[c], near.lanes[t], near.past[t], near.who[t],
        )


@compiled
def own_share(t, mode, plain, shapes, grouped, flat, movers, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, advance, tallies, paces):
    """The rest of thread t's chunks."""
    b = bodies_again(plain, shapes, grouped)
    if PAIRS:
        give_kept(near.share[t] * CHUNK, near.share[t + 1] * CHUNK, b, near)
    for c in range(near.share[t], near.share[t + 1]):
        if PAIRS:
            contacts(
                c, near.chunks[c, FIRST], near.chunks[c, END], b.x.shape[0], b, p, near, shifts, equal, coefficients, ntypes, dt, advance, tallies[c],
                near.lanes[t], near.past[t], near.who[t],
            )
        paces[c] = end_step(c, mode, b, flat, movers, near.pushed, walls, fields, dt, advance, tallies[c])


@threaded
def sweep_shares(mode, plain, shapes, grouped, flat, movers, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, advance, tallies, paces):
    """All threads do their shares."""
    threads = near.share.shape[0] - 1
    if PAIRS:
        for t in prange(threads):
            cross_share(t, plain, shapes, grouped, p, near, shifts, equal, coefficients, ntypes, dt, advance, tallies)
    for t in prange(threads):
        own_share(
            t, mode, plain, shapes, grouped, flat, movers, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, advance, tallies, paces
        )


@compiled
def sweep(mode, b, flat, movers, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, advance, tallies, paces):
    """Forces at the present positions and, by `mode`, the motion to the next. Returns the largest squared change of a velocity on the way."""
    chunks, everyone = tallies.shape[0], b.x.shape[0]
    if VIRIAL:
        tallies[:, 3] = 0.0
    if THREADED:
        sweep_shares(
            mode, plain_of(b), shapes_of(b), clumps_of(b), flat, movers, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, advance,
            tallies, paces,
        )
    else:
        for part in range(2):
            for k in range(chunks):
                c = chunks - 1 - k if part == 0 else k
                if PAIRS:
                    low, high = (CROSS_FIRST, CROSS_END) if part == 0 else (FIRST, END)
                    contacts(
                        c, near.chunks[c, low], near.chunks[c, high], everyone, b, p, near, shifts, equal, coefficients, ntypes, dt, advance, tallies[c],
                        near.lanes[0], near.past[0], near.who[0],
                    )
                if part == 1:
                    paces[c] = end_step(c, mode, b, flat, movers, near.pushed, walls, fields, dt, advance, tallies[c])
    jump = 0.0
    for c in range(chunks):
        jump = max(jump, paces[c])
    return jump


@inlined
def deep_contacts(tallies):
    """How many contacts were too deep since the guard last looked."""
    found = 0.0
    for c in range(tallies.shape[0]):
        found += tallies[c, 6]
    return found


@entry
def run_steps(
    start, steps, age, rhythm, b, flat, free, movers, clumps, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, tallies, paces, guard
):
    """Runs until `steps` are done; returns (steps done, age of the list, 0 or why it stopped before: DUE, the list in mid-step; TOO_FAST, TOO_DEEP).

    start: 0 at the begin of a step; 1 in mid-step, behind the renewal of the list; 2 set-up: forces only, histories stay.
    rhythm: (every, delay, check, squared half skin) as LAMMPS' neigh_modify. movers: how many particles move; they stand in the first rows, the first `free` of
    them on their own, the others with their clumps, if any are. flat: see state.Flat. guard: see guard.Guard.numbers.
    """
    every, delay, check, reach = rhythm
    n = b.x.shape[0]
    done, due = 0, 0
    jump = 0.0
    watch = START_WATCH
    if start == 0 and steps > 0:
        kick(NONE, free, 0.0, flat)
        if SHAPES:
            turn(NONE, free, TURN_FIRST, b, dt)
        drift(NONE, free, flat, dt)
        if CLUMPS and free < movers:
            move_clumps(False, False, True, b, clumps, dt)
    if steps > 0 or start == 2:
        clear(NONE, n, b)
        near.pushed[:] = 0
    if start != 0:
        near.scale[1] = 0.0
    fastest = top_speed(movers, b)
    haste, hasten = (most_haste(movers, b, guard), 1.0 / guard[4]) if GUARD else (0.0, 0.0)
    while done < steps or start == 2:
        if start == 0:
            if MOVING:
                move_walls(walls, dt)
            age += 1
            near.scale[1] += dt * fastest
            if age >= delay and age % every == 0:
                due = 0 if check else DUE
                # the way of the fastest of each step is a bound: while it is below, nobody can have gone too far
                if check and (not PAIRS or SHIFTING or near.scale[1] ** 2 >= 0.999 * reach):
                    gone = farthest(b)
                    due = DUE if gone > reach else 0
                    if PAIRS:
                        near.scale[1], fastest = sqrt(gone), top_speed(movers, b)
                if due != 0:
                    break
        if PAIRS:
            watch = renew_near(watch, b, movers, p, near, shifts, equal, dt, sqrt(jump))
            if watch[0] == 0.0:
                fastest = top_speed(movers, b)
        mode = FORCES if start == 2 else (GO_ON if done + 1 < steps else FINISH)
        jump = sweep(mode, b, flat, free, p, near, shifts, equal, coefficients, ntypes, walls, fields, dt, start != 2, tallies, paces)
        if CLUMPS:
            jump = max(jump, move_clumps(True, free < movers and mode != FORCES, free < movers and mode == GO_ON, b, clumps, dt))
            if mode == GO_ON:
                clear(free, n, b)
        if start == 2:
            break
        fastest += sqrt(jump)
        done += 1
        start = 0
        if GUARD:
            haste += sqrt(jump) * hasten  # a bound, as for the list
            if haste > guard[0]:
                haste = most_haste(movers, b, guard)
            if haste > guard[0] or (guard[5] != 0.0 and deep_contacts(tallies) > 0.0):
                if done == steps:
                    due = TOO_FAST if haste > guard[0] else TOO_DEEP
                else:
                    steps = done + 1  # the particles are on their way: this step is done too
    return done, age, due
