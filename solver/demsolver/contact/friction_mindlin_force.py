"""Mindlin's spring grown by increments of force, with dashpot and Coulomb's bound on their sum, as LAMMPS' tangential mindlin/force computes it:

    |T.n| > 1e-10 mu |Fn|:  T is projected onto the tangent plane and stretched to its old length         (only when advance)
    T -= kt dt vt                                                                                         (only when advance)
    Ft = T - gt vt
    |Ft| > mu |Fn|:  Ft *= mu |Fn|/|Ft|,  T = Ft + gt vt;  Ft = 0 where T = 0

What is stored is the force T of the spring, energy T^2/(2 kt), so kt acts on today's increment alone (C. Thornton et al., Powder Technol. 233
(2013) 30, doi:10.1016/j.powtec.2012.08.012, eq. 18). T stays while the contact opens and kt falls: that gives energy from nothing, T^2/2 (1/kt_1 -
1/kt_2) in a cycle loaded at kt_2 and unloaded at kt_1; the other way round as much is lost. Source: LAMMPS documentation, pair_style granular,
mindlin/force. Not: mindlin_rescale/force, which lets T fall with the contact radius.
"""

from math import sqrt

MEMORY = {"elastic_x": -1, "elastic_y": -1, "elastic_z": -1}


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
    elastic_x: float,
    elastic_y: float,
    elastic_z: float,
    dt: float,
    advance: bool,
) -> tuple[float, float, float, float, float, float]:
    """Tangential force on the particle, and the new force of the spring."""
    tx, ty, tz = elastic_x, elastic_y, elastic_z
    limit = mu * critical_force
    if advance:
        along = tx * nx + ty * ny + tz * nz
        if abs(along) > 1e-10 * limit:
            length = sqrt(tx * tx + ty * ty + tz * tz)
            tx, ty, tz = tx - along * nx, ty - along * ny, tz - along * nz
            projected = sqrt(tx * tx + ty * ty + tz * tz)
            stretch = length / projected if projected > 0.0 else 0.0
            tx, ty, tz = stretch * tx, stretch * ty, stretch * tz
        tx, ty, tz = tx - kt * dt * vtx, ty - kt * dt * vty, tz - kt * dt * vtz
    fx, fy, fz = tx - gt * vtx, ty - gt * vty, tz - gt * vtz
    size = sqrt(fx * fx + fy * fy + fz * fz)
    if size > limit:
        if tx == 0.0 and ty == 0.0 and tz == 0.0:
            return 0.0, 0.0, 0.0, tx, ty, tz
        cut = limit / size
        fx, fy, fz = cut * fx, cut * fy, cut * fz
        tx, ty, tz = fx + gt * vtx, fy + gt * vty, fz + gt * vtz
    return fx, fy, fz, tx, ty, tz


def energy(kt: float, elastic_x: float, elastic_y: float, elastic_z: float) -> float:
    """Energy of the spring, T^2/(2 kt); without a spring there is none."""
    square = elastic_x * elastic_x + elastic_y * elastic_y + elastic_z * elastic_z
    return 0.5 * square / kt if kt > 0.0 else 0.0
