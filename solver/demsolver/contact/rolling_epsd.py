"""Rolling resistance by a spring and a dashpot of torque, as LIGGGHTS' "elastic plastic spring dashpot" computes it:

    u = arm_ratio w;   torsion 0: less its part along n
    kr = 2.25 kn rolling_friction^2 R*^2                            kn = F_elastic/overlap, of this moment
    h += dt kr u                                           the torque of the spring is kept, not its angle
    |h| > rolling_friction R* |F|:  h is cut to that size, T = -h
    else:                  T = -h - 2 damping sqrt(I kr) u

At set-up T holds the step dt kr u all the same, and h stays. F is the normal force, damping and all (critical_force). Units: h [torque];
rolling_friction, rolling_damping_ratio (1 is critical), torsion [1].

Stores h^2/(2 kr arm_ratio): arm_ratio, not 1 at a wall, is there because h feels u and the particle w. Dissipates where h is cut, and by the
dashpot; neither ever gives energy. But energy appears from nothing
 - where kn falls (a Hertz contact that opens): the torque h stays, in a softer spring, which holds more;
 - where n turns, for h does not turn with it: the part of h that has come to lie along n drives or brakes the twist and, torsion being 0, does not
   run down; with torsion 1 it does;
 - where a pair parts and touches again before the neighbour list is rebuilt: it finds its old h.

Source: K. Iwashita, M. Oda, J. Eng. Mech. 124 (1998) 285, doi:10.1061/(ASCE)0733-9399(1998)124:3(285); J. Ai et al., Powder Technol. 206 (2011)
269, doi:10.1016/j.powtec.2010.09.030, model C; LIGGGHTS documentation, gran rolling_friction epsd, 3.8.0; measured, test_rolling_liggghts.py.
"""

from math import sqrt

MEMORY = {"rx": -1, "ry": -1, "rz": -1}
RANGES = {"torsion": (0.0, 1.0)}


def torque(
    stiffness: float,
    critical_force: float,
    reff: float,
    rolling_inertia: float,
    arm_ratio: float,
    rolling_friction: float,
    rolling_damping_ratio: float,
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
    """Torque on the particle, and the new torque of the spring (its opposite, the dashpot left out)."""
    along = (1.0 - torsion) * (wx * nx + wy * ny + wz * nz)
    ux, uy, uz = arm_ratio * (wx - along * nx), arm_ratio * (wy - along * ny), arm_ratio * (wz - along * nz)
    kr = 2.25 * stiffness * rolling_friction * rolling_friction * reff * reff
    hx, hy, hz = rx + dt * kr * ux, ry + dt * kr * uy, rz + dt * kr * uz
    limit = rolling_friction * reff * critical_force
    size = sqrt(hx * hx + hy * hy + hz * hz)
    damper = 2.0 * rolling_damping_ratio * sqrt(rolling_inertia * kr)
    if size > limit:
        cut = limit / size
        hx, hy, hz, damper = cut * hx, cut * hy, cut * hz, 0.0
    qx, qy, qz = -hx - damper * ux, -hy - damper * uy, -hz - damper * uz
    if not advance:
        hx, hy, hz = rx, ry, rz
    return qx, qy, qz, hx, hy, hz


def energy(
    stiffness: float,
    reff: float,
    radius: float,
    overlap: float,
    partner_curvature: float,
    rolling_friction: float,
    rx: float,
    ry: float,
    rz: float,
) -> float:
    """Energy of the spring, h^2/(2 kr arm_ratio)."""
    kr = 2.25 * stiffness * rolling_friction * rolling_friction * reff * reff
    if kr == 0.0:
        return 0.0
    arm_ratio = (radius - 0.5 * overlap) / (radius - overlap) if partner_curvature == 0.0 else 1.0
    return 0.5 * (rx * rx + ry * ry + rz * rz) / (kr * arm_ratio)
