"""Spring and dashpot with Coulomb's bound on their sum, as LAMMPS' gran/*/history styles compute it:

    s += dt vt;  s -= (s.n) n                       (only when advance)
    Ft = -kt s - gt vt
    |Ft| > mu |Fn|:  Ft *= mu |Fn|/|Ft|,  s = -(Ft + gt vt)/kt, which is s + (1 - mu |Fn|/|Ft|) Ft/kt with the old Ft
                     Ft = 0 where there was no s before the projection

|Ft| <= mu |Fn| always. s turns by projection onto the current tangent plane, so its length shrinks a little. The reset of s on
slip happens at setup too. Source: P. A. Cundall, O. D. L. Strack, Geotechnique 29 (1979) 47, doi:10.1680/geot.1979.29.1.47;
L. E. Silbert et al., Phys. Rev. E 64 (2001) 051302, doi:10.1103/PhysRevE.64.051302; LAMMPS documentation, pair_style
gran/hooke/history. Not: mindlin_rescale; at kt = 0, where LAMMPS divides by zero, s is left alone.
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
    moved = sx != 0.0 or sy != 0.0 or sz != 0.0
    if advance:
        along = sx * nx + sy * ny + sz * nz
        sx, sy, sz = sx - along * nx, sy - along * ny, sz - along * nz
    fx, fy, fz = -kt * sx - gt * vtx, -kt * sy - gt * vty, -kt * sz - gt * vtz
    limit = mu * critical_force
    size = sqrt(fx * fx + fy * fy + fz * fz)
    cut = min(1.0, limit / max(size, 1e-200))
    if not moved and cut < 1.0:
        return 0.0, 0.0, 0.0, sx, sy, sz
    give = (1.0 - cut) * (1.0 / kt) if kt > 0.0 else 0.0  # 0 where it holds: no question asked, for whether a contact slips is hard to foretell
    return cut * fx, cut * fy, cut * fz, sx + give * fx, sy + give * fy, sz + give * fz


def energy(kt: float, sx: float, sy: float, sz: float) -> float:
    """Energy of the spring, kt s^2/2."""
    return 0.5 * kt * (sx * sx + sy * sy + sz * sz)
