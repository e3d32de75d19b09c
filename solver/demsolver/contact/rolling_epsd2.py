"""Rolling resistance by a spring of torque alone, as LIGGGHTS' epsd2 computes it:

    u = arm_ratio w;   torsion 0: less its part along n
    kr = kt R*^2                                           kt the tangential stiffness of this moment
    h += dt kr u                                           the torque of the spring is kept, not its angle
    |h| > rolling_friction R* |F|:  h is cut to that size
    T = -h

At set-up T holds the step dt kr u all the same, and h stays. F is the normal force, damping and all (critical_force). Units: h [torque];
rolling_friction, torsion [1].

Stores h^2/(2 kr arm_ratio) and dissipates where h is cut. As with rolling_epsd.py energy appears from nothing where kt falls, where n turns away
from h (torsion 0), and where a pair touches again before the neighbour list is rebuilt.

Source: K. Iwashita, M. Oda, J. Eng. Mech. 124 (1998) 285, doi:10.1061/(ASCE)0733-9399(1998)124:3(285), for kr = kt R*^2; LIGGGHTS documentation,
gran rolling_friction epsd2, 3.8.0; measured, test_rolling_liggghts.py. Not: the dashpot of epsd.
"""

from math import sqrt

MEMORY = {"rx": -1, "ry": -1, "rz": -1}
RANGES = {"torsion": (0.0, 1.0)}


def torque(
    kt: float,
    critical_force: float,
    reff: float,
    arm_ratio: float,
    rolling_friction: float,
    torsion: float,
    nx: float,
    ny: float,
    nz: float,
    wx: float,
    wy: float,
    wz: float,
    rx: float,
    ry: float,
    rz: float,
    dt: float,
    advance: bool,
) -> tuple[float, float, float, float, float, float]:
    """Torque on the particle, and the new torque of the spring (its opposite)."""
    along = (1.0 - torsion) * (wx * nx + wy * ny + wz * nz)
    turn = dt * kt * reff * reff * arm_ratio
    hx, hy, hz = rx + turn * (wx - along * nx), ry + turn * (wy - along * ny), rz + turn * (wz - along * nz)
    limit = rolling_friction * reff * critical_force
    size = sqrt(hx * hx + hy * hy + hz * hz)
    if size > limit:
        cut = limit / size
        hx, hy, hz = cut * hx, cut * hy, cut * hz
    if advance:
        rx, ry, rz = hx, hy, hz
    return -hx, -hy, -hz, rx, ry, rz


def energy(kt: float, reff: float, radius: float, overlap: float, partner_curvature: float, rx: float, ry: float, rz: float) -> float:
    """Energy of the spring, h^2/(2 kr arm_ratio)."""
    kr = kt * reff * reff
    if kr == 0.0:
        return 0.0
    arm_ratio = (radius - 0.5 * overlap) / (radius - overlap) if partner_curvature == 0.0 else 1.0
    return 0.5 * (rx * rx + ry * ry + rz * rz) / (kr * arm_ratio)
