"""Spring with Coulomb's bound, dashpot outside of it, as LIGGGHTS' tangential history computes it:

    s += dt vt;  s -= (s.n) n                       (only when advance)
    kt |s| > mu |Fn|:  Ft = -mu |Fn| s/|s|, no damping;  s shrinks to mu |Fn|/kt (only when advance)
    else:              Ft = -kt s - gt vt

Only the spring obeys |.| <= mu |Fn|: a sticking contact may exceed the bound without limit through its damping. Source:
LIGGGHTS documentation, gran tangential history; measured, test_against_liggghts.py. Not: rescaled when
the contact unloads.
"""

from math import sqrt

MEMORY = {"sx": -1, "sy": -1, "sz": -1}


def force(
    critical_force: float,
    kt: float,
    gt: float,
    mu: float,
    nx: float,
    ny: float,
    nz: float,
    vtx: float,
    vty: float,
    vtz: float,
    sx: float,
    sy: float,
    sz: float,
    dt: float,
    advance: bool,
) -> tuple[float, float, float, float, float, float]:
    """Tangential force on the particle, and the new history vector."""
    if advance:
        sx, sy, sz = sx + dt * vtx, sy + dt * vty, sz + dt * vtz
        along = sx * nx + sy * ny + sz * nz
        sx, sy, sz = sx - along * nx, sy - along * ny, sz - along * nz
    limit = mu * critical_force
    spring = kt * sqrt(sx * sx + sy * sy + sz * sz)
    if spring > limit:
        cut = limit / spring
        fx, fy, fz = -kt * sx * cut, -kt * sy * cut, -kt * sz * cut
        if advance:
            sx, sy, sz = cut * sx, cut * sy, cut * sz
        return fx, fy, fz, sx, sy, sz
    return -kt * sx - gt * vtx, -kt * sy - gt * vty, -kt * sz - gt * vtz, sx, sy, sz


def energy(kt: float, sx: float, sy: float, sz: float) -> float:
    """Energy of the spring, kt s^2/2."""
    return 0.5 * kt * (sx * sx + sy * sy + sz * sz)
