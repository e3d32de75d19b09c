"""Rolling resistance of the DEM primer: a torque of constant size against the relative spin w.

    M_i = -rolling_friction R_i |Fn| w/|w|,  w = omega_i - omega_j  (a wall: less the wall's own);  0 where w = 0

All of w counts, the part about the normal too. Source: K. Shobuzako, "DEM no kiso" (2025), eq. 1.20. Dimensionless coefficient (its mu_r).
M_j has R_j in place of R_i and points the other way: between unlike spheres the two torques do not cancel, so angular momentum is not conserved,
and where (R_i omega_i - R_j omega_j).w < 0 they give energy (both spin the same way, the larger one more slowly). Between equal spheres and at walls
they only take. Nothing is remembered and nothing stored; a contact at rest feels nothing, so in steps dt its spin trembles about zero by up to
M dt/I. Not: a static resistance; a ball on a slope too gentle to roll creeps by that tremble.
"""

from math import sqrt

MEMORY: dict[str, int] = {}
SCALES_WITH_RADIUS = True


def torque(critical_force: float, radius: float, rolling_friction: float, wx: float, wy: float, wz: float) -> tuple[float, float, float]:
    """Torque on the particle."""
    speed = sqrt(wx * wx + wy * wy + wz * wz)
    if speed == 0.0:
        return 0.0, 0.0, 0.0
    size = -rolling_friction * radius * critical_force / speed
    return size * wx, size * wy, size * wz


def energy() -> float:
    """Nothing is stored."""
    return 0.0
