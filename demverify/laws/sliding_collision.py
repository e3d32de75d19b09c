"""Two spheres or discs collide and slide on each other throughout: impulses along and across the line of centres n at the touch,

    P_n = m* (1 + e) v_n,   P_t = mu P_n against the slip v_t + (R1 w1 + R2 w2) x n,   dw_i = R_i n x P_t/I_i,   I = inertia m R^2

(rigid bodies: Walton & Braun 1986, doi:10.1122/1.549893; Foerster et al. 1994, doi:10.1063/1.868282, eq. 4-8, branch of sliding). Slides to
the end where mu (1 + e) v_n (1 + 1/inertia) is below the slip. n stays as it is in the limit of a hard contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demverify.frames import Frame
from demverify.laws import Measured
from demverify.mechanics import positions, spins, velocities


def measure(frames: Sequence[Frame], restitution: float, friction: float, inertia: float) -> list[Measured]:
    """Velocities and spins of the first two particles at the end, largest miss, relative to the impact speed (spins: over the radius).

    inertia: I/(m R^2), 0.4 of spheres, 0.5 of discs."""
    first, last = frames[0], frames[-1]
    mass, radius = first.columns["mass"][:2], first.columns["radius"][:2]
    apart, v = positions(first)[0] - positions(first)[1], velocities(first)[0] - velocities(first)[1]
    w = radius @ spins(first)[:2]  # R1 w1 + R2 w2
    reach = radius.sum()
    along, square = float(apart @ v), float(v @ v)
    touch = (-along - np.sqrt(along**2 - square * (float(apart @ apart) - reach**2))) / square
    n = (apart + v * touch) / reach  # from the second to the first
    approach = -float(v @ n)
    slip = v + approach * n - np.cross(w, n)
    reduced = mass[0] * mass[1] / mass.sum()
    push = reduced * (1.0 + restitution) * approach
    across = -friction * push * slip / np.linalg.norm(slip)
    turn = -np.cross(n, across)  # arm of the first: -R1 n, of the second: +R2 n with -P_t, the same torque over R
    expected_v = velocities(first)[:2] + np.outer([1.0, -1.0], push * n + across) / mass[:, None]
    expected_w = spins(first)[:2] + np.outer(1.0 / (inertia * mass * radius), turn)
    off = np.abs(velocities(last)[:2] - expected_v).max()
    spin = np.abs(spins(last)[:2] - expected_w).max() * radius.min()
    size = float(np.linalg.norm(v))
    return [Measured("velocities", last.step, float(off), 0.0, size), Measured("spins", last.step, float(spin), 0.0, size)]
