"""Mindlin's spring that shrinks as the contact opens, with dashpot and Coulomb's bound on their sum, as LAMMPS' mindlin_rescale computes it:

    a < a of the last step:  s *= a/a of the last step                                                    (also at set-up)
    kt |s.n| > 1e-10 mu |Fn|:  s is projected onto the tangent plane and stretched to its old length      (only when advance)
    s += dt vt                                                                                            (only when advance)
    Ft = -kt s - gt vt
    |Ft| > mu |Fn|:  Ft *= mu |Fn|/|Ft|,  s = -(Ft + gt vt)/kt;  Ft = 0 where s = 0

The energy kt s^2/2 falls with a^3 as the contact opens, but rises with a as it closes on a stretched spring: that gives energy from nothing,
(kt_2 - kt_1) s^2/2 in a cycle loaded at kt_1 and unloaded at kt_2. The displacement is rescaled, not the force as C. Thornton et al., Powder
Technol. 233 (2013) 30, doi:10.1016/j.powtec.2012.08.012, do. Source: LAMMPS documentation, pair_style granular, mindlin_rescale. Not:
mindlin_rescale/force.
"""

from math import sqrt

MEMORY = {"sx": -1, "sy": -1, "sz": -1, "last_radius": 1}


def force(
    critical_force: float,
    contact_radius: float,
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
    last_radius: float,
    dt: float,
    advance: bool,
) -> tuple[float, float, float, float, float, float, float]:
    """Tangential force on the particle, and the new history: vector and contact radius."""
    limit = mu * critical_force
    if contact_radius < last_radius:
        shrink = contact_radius / last_radius
        sx, sy, sz = shrink * sx, shrink * sy, shrink * sz
    if advance:
        along = sx * nx + sy * ny + sz * nz
        if abs(along) * kt > 1e-10 * limit:
            length = sqrt(sx * sx + sy * sy + sz * sz)
            sx, sy, sz = sx - along * nx, sy - along * ny, sz - along * nz
            projected = sqrt(sx * sx + sy * sy + sz * sz)
            stretch = length / projected if projected > 0.0 else 0.0
            sx, sy, sz = stretch * sx, stretch * sy, stretch * sz
        sx, sy, sz = sx + dt * vtx, sy + dt * vty, sz + dt * vtz
        last_radius = contact_radius
    fx, fy, fz = -kt * sx - gt * vtx, -kt * sy - gt * vty, -kt * sz - gt * vtz
    size = sqrt(fx * fx + fy * fy + fz * fz)
    if size > limit:
        if sx == 0.0 and sy == 0.0 and sz == 0.0:
            return 0.0, 0.0, 0.0, sx, sy, sz, last_radius
        cut = limit / size
        fx, fy, fz = cut * fx, cut * fy, cut * fz
        if kt > 0.0:
            sx, sy, sz = -(fx + gt * vtx) / kt, -(fy + gt * vty) / kt, -(fz + gt * vtz) / kt
    return fx, fy, fz, sx, sy, sz, last_radius


def energy(kt: float, sx: float, sy: float, sz: float) -> float:
    """Energy of the spring, kt s^2/2."""
    return 0.5 * kt * (sx * sx + sy * sy + sz * sz)
