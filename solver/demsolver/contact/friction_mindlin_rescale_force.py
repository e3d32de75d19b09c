"""Mindlin's spring grown by increments of force that falls as the contact opens, as LAMMPS' mindlin_rescale/force computes it:

    a < a of the last step:  T *= a/a of the last step                                                    (also at set-up)
    |T.n| > 1e-10 mu |Fn|:  T is projected onto the tangent plane and stretched to its old length         (only when advance)
    T -= kt dt vt                                                                                         (only when advance)
    Ft = T - gt vt
    |Ft| > mu |Fn|:  Ft *= mu |Fn|/|Ft|,  T = Ft + gt vt;  Ft = 0 where T = 0

Energy T^2/(2 kt). It never comes from nothing: as the contact closes, T stays and kt rises; as it opens, T falls with kt; either way some is lost.
Source: C. Thornton et al., Powder Technol. 233 (2013) 30, doi:10.1016/j.powtec.2012.08.012, eq. 18; LAMMPS documentation, pair_style granular,
mindlin_rescale/force. Not: the spring of displacements, mindlin_rescale.
"""

from math import sqrt

MEMORY = {"elastic_x": -1, "elastic_y": -1, "elastic_z": -1, "last_radius": 1}


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
    elastic_x: float,
    elastic_y: float,
    elastic_z: float,
    last_radius: float,
    dt: float,
    advance: bool,
) -> tuple[float, float, float, float, float, float, float]:
    """Tangential force on the particle, and the new history: force of the spring and contact radius."""
    tx, ty, tz = elastic_x, elastic_y, elastic_z
    limit = mu * critical_force
    if contact_radius < last_radius:
        shrink = contact_radius / last_radius
        tx, ty, tz = shrink * tx, shrink * ty, shrink * tz
    if advance:
        along = tx * nx + ty * ny + tz * nz
        if abs(along) > 1e-10 * limit:
            length = sqrt(tx * tx + ty * ty + tz * tz)
            tx, ty, tz = tx - along * nx, ty - along * ny, tz - along * nz
            projected = sqrt(tx * tx + ty * ty + tz * tz)
            stretch = length / projected if projected > 0.0 else 0.0
            tx, ty, tz = stretch * tx, stretch * ty, stretch * tz
        tx, ty, tz = tx - kt * dt * vtx, ty - kt * dt * vty, tz - kt * dt * vtz
        last_radius = contact_radius
    fx, fy, fz = tx - gt * vtx, ty - gt * vty, tz - gt * vtz
    size = sqrt(fx * fx + fy * fy + fz * fz)
    if size > limit:
        if tx == 0.0 and ty == 0.0 and tz == 0.0:
            return 0.0, 0.0, 0.0, tx, ty, tz, last_radius
        cut = limit / size
        fx, fy, fz = cut * fx, cut * fy, cut * fz
        tx, ty, tz = fx + gt * vtx, fy + gt * vty, fz + gt * vtz
    return fx, fy, fz, tx, ty, tz, last_radius


def energy(kt: float, elastic_x: float, elastic_y: float, elastic_z: float) -> float:
    """Energy of the spring, T^2/(2 kt); without a spring there is none."""
    square = elastic_x * elastic_x + elastic_y * elastic_y + elastic_z * elastic_z
    return 0.5 * square / kt if kt > 0.0 else 0.0
