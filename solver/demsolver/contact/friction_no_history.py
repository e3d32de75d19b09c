"""Viscous friction with Coulomb's bound: Ft = -min(gt, mu |Fn|/|vt|) vt.

|Ft| <= mu |Fn|, also where the normal force pulls. Source: LAMMPS documentation, pair_style gran/hooke, and granular tangential
linear_nohistory; LIGGGHTS tangential no_history. Not: static friction; a slope creeps.
"""

from math import sqrt

HISTORY = False


def force(
    normal_force: float, gt: float, mu: float, vtx: float, vty: float, vtz: float, sx: float, sy: float, sz: float
) -> tuple[float, float, float, float, float, float]:
    """Tangential force on the particle, and the history vector as it came."""
    limit = mu * abs(normal_force)
    speed = sqrt(vtx * vtx + vty * vty + vtz * vtz)
    g = gt if gt * speed <= limit else limit / speed
    return -g * vtx, -g * vty, -g * vtz, sx, sy, sz
