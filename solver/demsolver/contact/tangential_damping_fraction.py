"""Tangential damping as a multiple of sqrt(mass stiffness): gt = tangential_fraction sqrt(meff kt).

Source: LIGGGHTS model hertz, tangential_fraction = -2 sqrt(5/6) L/sqrt(L^2 + pi^2), L = ln(restitution). Dimensionless.
"""

from math import sqrt


def coefficient(meff: float, kt: float, tangential_fraction: float) -> float:
    """Tangential damping coefficient gt."""
    return tangential_fraction * sqrt(meff * kt)
