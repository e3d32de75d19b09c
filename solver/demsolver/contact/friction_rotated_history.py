"""Spring and dashpot with Coulomb's bound on their sum, the spring turning with the contact, as LAMMPS' pair granular has it:

    kt |s.n| > 1e-10 mu |Fn|:  s is projected onto the tangent plane and stretched to its old length      (only when advance)
    s += dt vt                                                                                            (only when advance)
    Ft = -kt s - gt vt
    |Ft| > mu |Fn|:  Ft *= mu |Fn|/|Ft|,  s = -(Ft + gt vt)/kt;  Ft = 0 where s = 0

|Ft| <= mu |Fn| always. The reset of s on slip happens at setup too. Source: S. Luding, Granular Matter 10 (2008) 235,
doi:10.1007/s10035-008-0099-x, eq. 17; C. Thornton et al., Powder Technol. 233 (2013) 30, doi:10.1016/j.powtec.2012.08.012;
LAMMPS documentation, pair_style granular, tangential linear_history and mindlin. Not: mindlin_rescale, mindlin/force; at kt = 0,
where LAMMPS divides by zero, s is left alone.
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
    limit = mu * critical_force
    if advance:
        along = sx * nx + sy * ny + sz * nz
        if abs(along) * kt > 1e-10 * limit:
            length = sqrt(sx * sx + sy * sy + sz * sz)
            sx, sy, sz = sx - along * nx, sy - along * ny, sz - along * nz
            projected = sqrt(sx * sx + sy * sy + sz * sz)
            stretch = length / projected if projected > 0.0 else 0.0
            sx, sy, sz = stretch * sx, stretch * sy, stretch * sz
        sx, sy, sz = sx + dt * vtx, sy + dt * vty, sz + dt * vtz
    fx, fy, fz = -kt * sx - gt * vtx, -kt * sy - gt * vty, -kt * sz - gt * vtz
    size = sqrt(fx * fx + fy * fy + fz * fz)
    if size > limit:
        if sx == 0.0 and sy == 0.0 and sz == 0.0:
            return 0.0, 0.0, 0.0, sx, sy, sz
        cut = limit / size
        fx, fy, fz = cut * fx, cut * fy, cut * fz
        if kt > 0.0:
            sx, sy, sz = -(fx + gt * vtx) / kt, -(fy + gt * vty) / kt, -(fz + gt * vtz) / kt
    return fx, fy, fz, sx, sy, sz


def energy(kt: float, sx: float, sy: float, sz: float) -> float:
    """Energy of the spring, kt s^2/2."""
    return 0.5 * kt * (sx * sx + sy * sy + sz * sz)
