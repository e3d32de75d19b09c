"""Dashpot as a multiple of sqrt(mass stiffness): gn = damping_fraction sqrt(meff F/overlap), F the elastic force.

For a Hertz contact this makes the restitution independent of the impact speed. Source: Y. Tsuji et al., Powder Technol. 71
(1992) 239, doi:10.1016/0032-5910(92)88030-L. What the engines put for damping_fraction (e the wanted restitution, L = ln e):

    LAMMPS granular damping tsuji                    polynomial in e; as coded it misses the wanted e, see demverify/deck
    LAMMPS coeff_restitution, LIGGGHTS hooke         -2 L / sqrt(pi^2 + L^2)         linear spring
    LAMMPS coeff_restitution, LIGGGHTS hertz         -sqrt(5) L / sqrt(pi^2 + L^2)   Hertz spring

Dimensionless. Not: critical damping fraction; that is damping_fraction/2 for a linear spring.
"""

from math import sqrt


def coefficient(meff: float, stiffness: float, damping_fraction: float) -> float:
    """Normal damping coefficient gn."""
    return damping_fraction * sqrt(meff * stiffness)
