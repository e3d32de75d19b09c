"""Viscous friction with Coulomb's bound: Ft = -min(gt, mu |Fn|/|vt|) vt.

|Ft| <= mu |Fn|, also where the normal force pulls. Source: LAMMPS documentation, pair_style gran/hooke, and granular tangential
linear_nohistory; LIGGGHTS tangential no_history. Not: static friction; a slope creeps.
"""

from math import sqrt

MEMORY: dict[str, int] = {}


def force(
    critical_force: float, gt: float, mu: float, vtx: float, vty: float, vtz: float
) -> tuple[float, float, float]:
    """Tangential force on the particle."""
    limit = mu * critical_force
    speed = sqrt(vtx * vtx + vty * vty + vtz * vtz)
    g = gt if gt * speed <= limit else limit / speed
    return -g * vtx, -g * vty, -g * vtz


def energy() -> float:
    """Nothing is stored."""
    return 0.0
